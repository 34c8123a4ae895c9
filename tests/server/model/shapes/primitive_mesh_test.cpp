// Pillar, plate, bar, ellipsoid and bracket: sizes, volumes and distances by closed forms.
#include "server/model/shapes/primitive_mesh.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include "tests/server/model/shapes/mesh_measures.h"
#include "tests/server/model/shapes/relative.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr double kPi = std::numbers::pi;

void check_sound(const TriangleMesh& mesh) {
  const MeshMeasures measures = measure(mesh);
  CHECK(measures.closed);
  CHECK(measures.pieces == 1);
  CHECK(measures.euler == 2);
  CHECK(measures.flattest > 1e-4L);
}

void check_box(const TriangleMesh& mesh, const Vector3& low, const Vector3& high) {
  const MeshMeasures measures = measure(mesh);
  CHECK((measures.low - low).norm() < 1e-12);
  CHECK((measures.high - high).norm() < 1e-12);
}

/// Random points of all triangles lie within `deviation` inside the surface and nowhere outside.
void check_facets(const TriangleMesh& mesh, double deviation,
                  const std::function<double(const Vector3&)>& distance) {
  SplitMix64 random(1);
  double highest = -1.0;
  double lowest = 1.0;
  for (const Triangle& triangle : mesh.triangles) {
    for (int k = 0; k < 4; ++k) {
      const double u = random.uniform();
      const double v = random.uniform(0.0, 1.0 - u);
      const double d = distance(point_of(mesh, triangle, u, v));
      highest = std::max(highest, d);
      lowest = std::min(lowest, d);
    }
  }
  CHECK(highest < 1e-12);
  CHECK(lowest > -deviation);
}

/// Distance to a box with half sizes `h` whose edges are rounded with r, by its inner box.
double rounded_box_distance(const Vector3& p, const Vector3& h, double r) {
  const Vector3 out = (p.cwiseAbs() - h).array() + r;
  const double inside = std::min(out.maxCoeff(), 0.0);
  return out.cwiseMax(0.0).norm() + inside - r;
}

template <typename Make>
std::string complaint(const Make& make) {
  try {
    static_cast<void>(make());
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a pillar has the volume, box and surface of a cylinder with rounded rims") {
  PillarParameters p;
  p.deviation = 1e-5;
  const TriangleMesh mesh = make_pillar(p);
  check_sound(mesh);
  const double c = p.radius - p.rim;
  const double volume =
      kPi * p.radius * p.radius * (p.height - 2.0 * p.rim) +
      2.0 * kPi *
          (c * c * p.rim + c * kPi * p.rim * p.rim / 2.0 + 2.0 / 3.0 * p.rim * p.rim * p.rim);
  CHECK(static_cast<double>(measure(mesh).volume) == relative(volume, 1e-3));
  CHECK(measure(mesh).low.y() == 0.0);
  CHECK(measure(mesh).high.y() == p.height);
  CHECK(measure(mesh).high.z() == relative(p.radius, 1e-12));
  check_facets(mesh, p.deviation, [&](const Vector3& q) {
    const Vector3 half(p.radius, 0.5 * p.height, 1.0);
    const Vector3 radial(std::hypot(q.x(), q.z()), q.y() - 0.5 * p.height, 0.0);
    return rounded_box_distance(radial, half, p.rim);
  });
}

TEST_CASE("a plate has the volume, box and surface of a box with rounded edges") {
  PlateParameters p;
  p.deviation = 1e-5;
  const TriangleMesh mesh = make_plate(p);
  check_sound(mesh);
  const Vector3 size(p.width, p.thickness, p.depth);
  check_box(mesh, -0.5 * size, 0.5 * size);
  const Vector3 s = size.array() - 2.0 * p.edge;
  const double r = p.edge;
  const double volume = s.prod() + 2.0 * r * (s[0] * s[1] + s[1] * s[2] + s[2] * s[0]) +
                        kPi * r * r * s.sum() + 4.0 / 3.0 * kPi * r * r * r;
  CHECK(static_cast<double>(measure(mesh).volume) == relative(volume, 1e-4));
  check_facets(mesh, p.deviation,
               [&](const Vector3& q) { return rounded_box_distance(q, 0.5 * size, p.edge); });
}

TEST_CASE("a bar has the volume, box and surface of a capsule along x") {
  const BarParameters p;
  const TriangleMesh mesh = make_bar(p);
  check_sound(mesh);
  const Vector3 half(0.5 * p.length, p.radius, p.radius);
  check_box(mesh, -half, half);
  check_facets(mesh, p.deviation, [&](const Vector3& q) {
    const double end = 0.5 * p.length - p.radius;
    return (q - Vector3(std::clamp(q.x(), -end, end), 0.0, 0.0)).norm() - p.radius;
  });
}

TEST_CASE("an ellipsoid's vertices lie on it and its facets just inside") {
  EllipsoidParameters p;
  p.semi_x = 0.03;
  p.semi_y = 0.01;
  const TriangleMesh mesh = make_ellipsoid(p);
  check_sound(mesh);
  const Vector3 semi(p.semi_x, p.semi_y, p.semi_z);
  double worst = 0.0;
  for (const Vector3& q : mesh.vertices) {
    worst = std::max(worst, std::fabs(q.cwiseQuotient(semi).norm() - 1.0));
  }
  CHECK(worst < 1e-14);
  const double volume = 4.0 / 3.0 * kPi * semi.prod();
  CHECK(static_cast<double>(measure(mesh).volume) == relative(volume, 5e-3));
}

TEST_CASE("a ball's facets lie within the deviation, whatever its size") {
  SplitMix64 random(2);
  for (std::int64_t k = 0; k < scaled(100); ++k) {
    EllipsoidParameters p;
    p.semi_x = p.semi_y = p.semi_z = random.uniform(0.001, 1.0);
    p.deviation = p.semi_x * random.uniform(1e-3, 9e-3);
    const TriangleMesh mesh = make_ellipsoid(p);
    check_facets(mesh, p.deviation, [&](const Vector3& q) { return q.norm() - p.semi_x; });
  }
}

TEST_CASE("brackets have the box they are given and the volume of their profile") {
  for (const double legs : {1.0, 2.0}) {
    BracketParameters p;
    p.legs = legs;
    p.deviation = 1e-5;
    const TriangleMesh mesh = make_bracket(p);
    check_sound(mesh);
    check_box(mesh, {-0.5 * p.width, 0.0, -0.5 * p.length},
              {0.5 * p.width, p.height, 0.5 * p.length});
    const double corner = 1.0 - kPi / 4.0;  // what rounding takes from a unit corner
    const double area = p.width * p.thickness + legs * (p.height - p.thickness) * p.thickness +
                        legs * corner * p.fillet * p.fillet -
                        (4.0 + legs) * corner * p.edge * p.edge;
    CHECK(static_cast<double>(measure(mesh).volume) == relative(area * p.length, 4e-3));
  }
}

TEST_CASE("a bracket's leg stands at the lower end of x, and only a U has a second one") {
  BracketParameters p;
  const auto highest_at = [&](double side) {
    double highest = 0.0;
    for (const Vector3& q : make_bracket(p).vertices) {
      if (q.x() * side > 0.0) highest = std::max(highest, q.y());
    }
    return highest;
  };
  CHECK(highest_at(-1.0) == p.height);
  CHECK(highest_at(1.0) == relative(p.thickness, 1e-9));
  p.legs = 2.0;
  CHECK(highest_at(1.0) == p.height);
}

TEST_CASE("random plates and pillars are sound or refused") {
  SplitMix64 random(3);
  for (std::int64_t k = 0; k < scaled(300); ++k) {
    PlateParameters plate;
    plate.width = random.uniform(1e-3, 0.5);
    plate.thickness = random.uniform(1e-3, 0.1);
    plate.depth = random.uniform(1e-3, 0.5);
    plate.edge = random.uniform(1e-5, 0.02);
    const bool possible = 2.0 * plate.edge < std::min({plate.width, plate.thickness, plate.depth});
    if (possible) {
      CHECK(measure(make_plate(plate)).closed);
    } else {
      CHECK(complaint([&] { return make_plate(plate); }).find("edge") != std::string::npos);
    }
  }
}

TEST_CASE("a parameter out of range is refused with its name and range") {
  PillarParameters pillar;
  pillar.radius = -1.0;
  CHECK(complaint([&] { return make_pillar(pillar); }) ==
        "pillar: radius is -1, must be from 0.001 to 1 m");
  pillar.radius = std::nan("");
  CHECK(complaint([&] { return make_pillar(pillar); }).find("radius") != std::string::npos);
  pillar.radius = 0.02;
  pillar.rim = 0.02;
  CHECK(complaint([&] { return make_pillar(pillar); }) == "pillar: rim must be below radius");
  BracketParameters bracket;
  bracket.legs = 1.5;
  CHECK(complaint([&] { return make_bracket(bracket); }) == "bracket: legs must be 1 or 2");
  BarParameters bar;
  bar.length = 0.005;
  CHECK(complaint([&] { return make_bar(bar); }).find("length") != std::string::npos);
}

}  // namespace hapticd::test
