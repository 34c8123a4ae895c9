// The hand: one smooth solid, pads on their ellipsoids, nails on the pads, and the index finger
// lowest with its lowest point below the origin.
#include "server/model/shapes/hand_model.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "server/model/shapes/mesh_building.h"
#include "tests/server/model/packing/test_meshes.h"
#include "tests/server/model/shapes/guqin_strings.h"
#include "tests/server/model/shapes/index_reach.h"
#include "tests/server/model/shapes/mesh_measures.h"
#include "tests/server/model/shapes/relative.h"

namespace hapticd::test {
namespace {

constexpr std::array<Finger, 5> kAll{Finger::kThumb, Finger::kIndex, Finger::kMiddle, Finger::kRing,
                                     Finger::kLittle};

/// p in the frame of the pad, in units of its semi-axes: length 1 on its surface.
Vector3 in_pad(const FingerPad& pad, const Vector3& p) {
  return (pad.R_G.transpose() * (p - pad.p_G)).cwiseQuotient(pad.semi_axes);
}

/// Distance of p from the string's surface, m.
double gap_to_string(const GuqinString& string, const Vector3& p) {
  const Vector3 axis = string.p_WB - string.p_WA;
  const double share = std::clamp((p - string.p_WA).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
  return (p - string.p_WA - share * axis).norm() - string.radius;
}

std::string complaint(const HandParameters& parameters) {
  try {
    static_cast<void>(make_finger_nail(parameters, Finger::kRing));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("the hand is one closed solid of the length given, without slivers") {
  HandParameters p;
  for (const double length : {0.18, 0.15}) {
    p.length = length;
    const TriangleMesh mesh = make_hand(p);
    const MeshMeasures measures = measure(mesh);
    CHECK(measures.closed);
    CHECK(measures.pieces == 1);
    CHECK(measures.euler == 2);
    CHECK(measures.flattest > 0.1L);
    CHECK(mesh.triangles.size() < 14'000);
    CHECK(measures.high.z() - measures.low.z() == relative(length, 0.03));
  }
  CHECK(make_hand({}).triangles.size() <= 8'000);
}

TEST_CASE("with every cell allowed the hand is one solid without handles") {
  HandParameters p;
  for (const double cells : {30.0, 34.0, 47.0}) {
    p.cell = p.length / cells;
    const MeshMeasures measures = measure(make_hand(p));
    CHECK(measures.closed);
    CHECK(measures.euler == 2);
    CHECK(measures.flattest > 0.1L);
  }
}

TEST_CASE("pads are ellipsoids of a fingertip's size, about 1000 triangles each") {
  for (const Finger finger : kAll) {
    const FingerPad pad = finger_pad({}, finger);
    CHECK((pad.R_G.transpose() * pad.R_G - Matrix3::Identity()).norm() < 1e-14);
    CHECK(pad.semi_axes.minCoeff() > 0.005);
    CHECK(pad.semi_axes.maxCoeff() < 0.013);
    const TriangleMesh mesh = make_finger_tip({}, finger);
    CHECK(measure(mesh).closed);
    CHECK(measure(mesh).euler == 2);
    CHECK(mesh.triangles.size() >= 600);
    CHECK(mesh.triangles.size() <= 1300);
    double worst = 0.0;
    for (const Vector3& p : mesh.vertices) {
      worst = std::max(worst, std::fabs(in_pad(pad, p).norm() - 1.0));
    }
    CHECK(worst < 1e-12);
  }
}

TEST_CASE("each finger ends inside its pad") {
  const TriangleMesh hand = make_hand({});
  for (const Finger finger : kAll) {
    const FingerPad pad = finger_pad({}, finger);
    CHECK(winding_number(hand, pad.p_G) > 0.5L);
    // Of the hand nothing comes near the front half of the pad from inside.
    for (const Vector3& p : hand.vertices) {
      const Vector3 q = in_pad(pad, p);
      if (q.z() > 0.0 && q.norm() < 1.5) REQUIRE(q.norm() < 0.95);
    }
  }
}

TEST_CASE("the lowest point of the index finger's pad is straight below the origin") {
  const HandParameters p;
  const double reach = index_reach(p);
  CHECK(reach > 0.006);
  CHECK(reach < 0.011);
  const FingerPad pad = finger_pad(p, Finger::kIndex);
  // The surface's point below the origin, and that nothing of the pad is lower.
  CHECK(in_pad(pad, {0.0, -reach, 0.0}).norm() == relative(1.0, 1e-12));
  CHECK(pad.p_G.y() == 0.0);
  double lowest = 0.0;
  for (const Vector3& q : make_finger_tip(p, Finger::kIndex).vertices) {
    lowest = std::min(lowest, q.y());
  }
  CHECK(lowest >= -reach - 1e-12);
  CHECK(lowest < -reach + 2e-4);
}

TEST_CASE("the index finger is lowest by more than a string's clearance") {
  const HandParameters p;
  const double lowest = -index_reach(p);
  double others = 1.0;
  for (const Vector3& q : make_hand(p).vertices) others = std::min(others, q.y());
  // The index finger's own shaft.
  CHECK(others > lowest + 0.003);
  for (const Finger finger : kAll) {
    if (finger == Finger::kIndex) continue;
    CHECK(measure(make_finger_tip(p, finger)).low.y() > lowest + 0.01);
    CHECK(measure(make_finger_nail(p, finger)).low.y() > lowest + 0.01);
  }
  CHECK(measure(make_finger_nail(p, Finger::kIndex)).low.y() > lowest + 0.001);
}

TEST_CASE("a right hand points along -z with its thumb at x < 0 and its palm below its back") {
  const HandParameters p;
  CHECK(finger_pad(p, Finger::kThumb).p_G.x() < finger_pad(p, Finger::kIndex).p_G.x());
  for (std::size_t i = 1; i < 4; ++i) {
    CHECK(finger_pad(p, kAll[i]).p_G.x() < finger_pad(p, kAll[i + 1]).p_G.x());
  }
  const MeshMeasures hand = measure(make_hand(p));
  CHECK(hand.high.z() > 0.15);
  CHECK(hand.low.z() > -0.02);
  // The index finger points forward and down, its nail up and forward.
  const FingerPad index = finger_pad(p, Finger::kIndex);
  CHECK(index.R_G(2, 2) < -0.5);
  CHECK(index.R_G(1, 2) < -0.5);
  CHECK(index.R_G(1, 1) > 0.5);
}

TEST_CASE("a left hand is the mirror image, to the bit") {
  HandParameters right;
  HandParameters left;
  left.left = 1.0;
  const auto check = [](const TriangleMesh& a, const TriangleMesh& b) {
    REQUIRE(a.vertices.size() == b.vertices.size());
    for (std::size_t i = 0; i < a.vertices.size(); ++i) {
      REQUIRE(a.vertices[i].x() == -b.vertices[i].x());
      REQUIRE(a.vertices[i].y() == b.vertices[i].y());
      REQUIRE(a.vertices[i].z() == b.vertices[i].z());
    }
    CHECK(measure(b).volume > 0.0L);
  };
  check(make_hand(right), make_hand(left));
  check(make_finger_tip(right, Finger::kIndex), make_finger_tip(left, Finger::kIndex));
  check(make_finger_nail(right, Finger::kThumb), make_finger_nail(left, Finger::kThumb));
  const FingerPad pad = finger_pad(left, Finger::kRing);
  CHECK(pad.p_G.x() == -finger_pad(right, Finger::kRing).p_G.x());
  for (const Vector3& p : make_finger_tip(left, Finger::kRing).vertices) {
    REQUIRE(std::fabs(in_pad(pad, p).norm() - 1.0) < 1e-12);
  }
}

TEST_CASE("nails have the thickness given, reach beyond the pad and lie on its back") {
  HandParameters p;
  for (const double thickness : {0.0009, 0.0006}) {
    p.nail_thickness = thickness;
    p.nail_reach = 0.0018 - 0.5 * (0.0009 - thickness);
    for (const Finger finger : kAll) {
      const FingerPad pad = finger_pad(p, finger);
      const TriangleMesh mesh = make_finger_nail(p, finger);
      const MeshMeasures measures = measure(mesh);
      CHECK(measures.closed);
      CHECK(measures.euler == 2);
      // Twice the volume over the area: the thickness of a plate, less what its rim adds to the
      // area.
      const auto plate = static_cast<double>(2.0L * measures.volume / measures.area);
      CHECK(plate > 0.86 * thickness);
      CHECK(plate < thickness);
      double foremost = 0.0;
      double inside = 2.0;
      for (const Vector3& q : mesh.vertices) {
        const Vector3 along = pad.R_G.transpose() * (q - pad.p_G);
        foremost = std::max(foremost, along.z());
        inside = std::min(inside, in_pad(pad, q).norm());
        REQUIRE(along.y() > 0.0);
      }
      CHECK(foremost - pad.semi_axes.z() == relative(p.nail_reach, 0.15));
      CHECK(inside < 1.0);
    }
  }
}

TEST_CASE("a hand that touches a string of the Guqin with its index finger touches nothing else") {
  const HandParameters p;
  const GuqinParameters guqin;
  const auto strings = guqin_strings(guqin);
  TriangleMesh pad = make_finger_tip(p, Finger::kIndex);
  TriangleMesh others = make_hand(p);
  for (const Finger finger : kAll) {
    if (finger != Finger::kIndex) append(others, make_finger_tip(p, finger));
    append(others, make_finger_nail(p, finger));
  }
  for (const GuqinString& touched : strings) {
    const Vector3 p_WS = touched.p_WA + 0.1 * (touched.p_WB - touched.p_WA);
    const Vector3 p_WG = p_WS + Vector3(0.0, index_reach(p) + touched.radius, 0.0);
    double pad_touched = 1.0;
    double pad_other = 1.0;
    double rest = 1.0;
    for (const GuqinString& string : strings) {
      double& pad_gap = &string == &touched ? pad_touched : pad_other;
      for (const Vector3& q : pad.vertices) {
        pad_gap = std::min(pad_gap, gap_to_string(string, q + p_WG));
      }
      for (const Vector3& q : others.vertices) {
        rest = std::min(rest, gap_to_string(string, q + p_WG));
      }
    }
    // The string rises a little towards the bridge.
    CHECK(pad_touched > -1e-4);
    CHECK(pad_touched < 3e-4);
    CHECK(pad_other > 0.008);
    CHECK(rest > 0.004);
    for (const TriangleMesh* mesh : {&pad, &others}) {
      for (const Vector3& q : mesh->vertices) {
        const Vector3 p_W = q + p_WG;
        const bool above = std::fabs(p_W.z()) < guqin_half_width(guqin, p_W.x());
        if (above) REQUIRE(p_W.y() - guqin_top(guqin, p_W.x(), p_W.z()) > 0.008);
      }
    }
  }
}

TEST_CASE("a hand that is neither right nor left, or of a giant, is refused by name") {
  HandParameters p;
  p.left = 0.5;
  CHECK(complaint(p) == "hand: left must be 0 or 1");
  p = {};
  p.length = 1.8;
  CHECK(complaint(p) == "hand: length is 1.8, must be from 0.1 to 0.3 m");
  p = {};
  p.cell = 0.007;
  CHECK(complaint(p) == "hand: cell must be at most a thirtieth of length");
  p.cell = std::nan("");
  CHECK(complaint(p).find("cell") != std::string::npos);
}

}  // namespace hapticd::test
