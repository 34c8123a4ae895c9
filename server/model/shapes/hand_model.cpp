// See hand_model.h.
#include "server/model/shapes/hand_model.h"

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"
#include "server/model/shapes/hand_pose.h"
#include "server/model/shapes/implicit_mesh.h"
#include "server/model/shapes/mesh_building.h"
#include "server/model/shapes/primitive_mesh.h"

namespace hapticd {
namespace {

/// Length that the skeleton is given for, m.
constexpr double kSkeletonLength = 0.18;
/// Cells along the hand: with fewer the gaps between the fingers are too narrow for the lattice and
/// the mesh touches itself there (seen from 26 down).
constexpr double kMinCells = 30.0;
/// How wide seams are filled, m, of the skeleton: within the palm, between palm and fingers, within
/// a finger, and between fingers, which stay apart.
constexpr double kPalmBlend = 0.014;
constexpr double kKnuckleBlend = 0.012;
constexpr double kJointBlend = 0.004;
constexpr double kWebBlend = 0.004;
/// Chords round a nail, and from its middle to its rim.
constexpr int kNailAround = 32;
constexpr int kNailRings = 4;
constexpr int kNailRim = 3;

HandParameters checked(const HandParameters& parameters) {
  check_parameters("hand", kHandFields, parameters);
  if (parameters.left != 0.0 && parameters.left != 1.0) {
    throw std::invalid_argument("hand: left must be 0 or 1");
  }
  if (parameters.cell > parameters.length / kMinCells) {
    throw std::invalid_argument("hand: cell must be at most a thirtieth of length");
  }
  return parameters;
}

/// Lowest point of an ellipsoid relative to its centre.
Vector3 lowest_point(const FingerPad& pad) {
  // Of the ellipsoid R diag(semi_axes) u, |u| = 1, the lowest has u along -(row y of the matrix).
  Vector3 u{0.0, 0.0, 0.0};
  double square = 0.0;
  for (int i = 0; i < 3; ++i) {
    u[i] = -pad.R_G(1, i) * pad.semi_axes[i];
    square += u[i] * u[i];
  }
  const double depth = std::sqrt(square);
  Vector3 offset{0.0, 0.0, 0.0};
  for (int i = 0; i < 3; ++i) offset += pad.R_G.col(i) * (pad.semi_axes[i] * (u[i] / depth));
  return offset;
}

/// Origin of G in the skeleton's frame.
Vector3 grip(const HandBones& hand) {
  const FingerPad& index = hand.fingers[1].pad;
  const Vector3 lowest = lowest_point(index);
  return {index.p_G.x() + lowest.x(), index.p_G.y(), index.p_G.z() + lowest.z()};
}

/// From the skeleton's frame to G.
void place(TriangleMesh& mesh, const HandParameters& parameters, const Vector3& p_grip) {
  const double scale = parameters.length / kSkeletonLength;
  for (Vector3& p : mesh.vertices) p = scale * (p - p_grip);
  if (parameters.left == 1.0) mesh = mirrored(mesh);
}

double union_of(const std::vector<RoundCone>& cones, const Vector3& p, double blend) {
  double result = distance(cones.front(), p);
  for (std::size_t i = 1; i < cones.size(); ++i) {
    result = smooth_minimum(result, distance(cones[i], p), blend);
  }
  return result;
}

double hand_distance(const HandBones& hand, const Vector3& p) {
  double fingers = union_of(hand.fingers.front().cones, p, kJointBlend);
  for (std::size_t i = 1; i < hand.fingers.size(); ++i) {
    fingers = smooth_minimum(fingers, union_of(hand.fingers[i].cones, p, kJointBlend), kWebBlend);
  }
  return smooth_minimum(union_of(hand.palm, p, kPalmBlend), fingers, kKnuckleBlend);
}

/// A nail lies on an ellipsoid a little larger than the pad.
struct NailBed {
  Vector3 semi_axes;  ///< as of the pad
  double half_width;  ///< across, m
  double begin, end;  ///< along, m
};

NailBed nail_bed(const FingerPad& pad, const HandParameters& parameters) {
  const double scale = parameters.length / kSkeletonLength;
  const double reach = parameters.nail_reach / scale;
  const Vector3& a = pad.semi_axes;
  // Longer along the finger, so that the nail bends less than the tip and ends above it.
  return {{a.x() + 0.0002, a.y() + 0.0002, a.z() + 0.0035 + reach},
          0.72 * a.x(),
          -0.28 * a.z(),
          a.z() + reach};
}

/// The point `height` above the bed at (u across along the arc, v along).
Vector3 on_bed(const NailBed& bed, double u, double v, double height) {
  const Vector3& a = bed.semi_axes;
  const double share = v / a.z();
  const double shrink = std::sqrt(1.0 - share * share);
  const SinCos turn = sin_cos(u / a.x());
  const Vector3 p{a.x() * shrink * turn.sin, a.y() * shrink * turn.cos, v};
  const Vector3 gradient{p.x() / (a.x() * a.x()), p.y() / (a.y() * a.y()), p.z() / (a.z() * a.z())};
  const double length = std::sqrt(gradient.x() * gradient.x() + gradient.y() * gradient.y() +
                                  gradient.z() * gradient.z());
  return p + gradient * (height / length);
}

/// One ring of a nail: the outline (a square with round sides, |u|^4 + |v|^4 = 1) drawn in by
/// `inset` m or, for the rings within, shrunk by `share`.
Loop nail_ring(const NailBed& bed, double inset, double share, double height) {
  const double half_length = 0.5 * (bed.end - bed.begin);
  const double middle = 0.5 * (bed.end + bed.begin);
  Loop loop;
  for (int k = 0; k < kNailAround; ++k) {
    const SinCos turn = sin_cos(2.0 * kPi * k / kNailAround);
    const double c2 = turn.cos * turn.cos;
    const double s2 = turn.sin * turn.sin;
    const double size = share / std::sqrt(std::sqrt(c2 * c2 + s2 * s2));
    loop.push_back(on_bed(bed, (bed.half_width - inset) * size * turn.cos,
                          middle - (half_length - inset) * size * turn.sin, height));
  }
  return loop;
}

}  // namespace

FingerPad finger_pad(const HandParameters& parameters, Finger finger) {
  const HandParameters p = checked(parameters);
  const HandBones hand = hand_bones();
  FingerPad pad = hand.fingers[static_cast<std::size_t>(finger)].pad;
  const double scale = p.length / kSkeletonLength;
  pad.p_G = scale * (pad.p_G - grip(hand));
  pad.semi_axes *= scale;
  if (p.left == 1.0) {
    pad.p_G.x() = -pad.p_G.x();
    pad.R_G.row(0) = -pad.R_G.row(0);
  }
  return pad;
}

TriangleMesh make_hand(const HandParameters& parameters) {
  const HandParameters p = checked(parameters);
  const HandBones hand = hand_bones();
  ImplicitMeshOptions options;
  options.cell = p.cell / (p.length / kSkeletonLength);
  // The cones' box with room for seams and lattice.
  options.low = options.high = hand.palm.front().p_a;
  const auto include = [&](const RoundCone& cone) {
    options.low = options.low.cwiseMin(cone.p_a.cwiseMin(cone.p_b));
    options.high = options.high.cwiseMax(cone.p_a.cwiseMax(cone.p_b));
  };
  for (const RoundCone& cone : hand.palm) include(cone);
  for (const FingerBones& finger : hand.fingers) {
    for (const RoundCone& cone : finger.cones) include(cone);
  }
  const double room = 0.02 + 2.0 * options.cell;
  options.low.array() -= room;
  options.high.array() += room;
  TriangleMesh mesh =
      mesh_implicit([&](const Vector3& q) { return hand_distance(hand, q); }, options);
  place(mesh, p, grip(hand));
  return mesh;
}

TriangleMesh make_finger_tip(const HandParameters& parameters, Finger finger) {
  const HandParameters p = checked(parameters);
  const HandBones hand = hand_bones();
  const FingerPad& pad = hand.fingers[static_cast<std::size_t>(finger)].pad;
  EllipsoidParameters ellipsoid;
  ellipsoid.semi_x = pad.semi_axes.x();
  ellipsoid.semi_y = pad.semi_axes.y();
  ellipsoid.semi_z = pad.semi_axes.z();
  ellipsoid.deviation = p.tip_deviation / (p.length / kSkeletonLength);
  TriangleMesh mesh = make_ellipsoid(ellipsoid);
  move(mesh, pad.R_G, pad.p_G);
  place(mesh, p, grip(hand));
  return mesh;
}

TriangleMesh make_finger_nail(const HandParameters& parameters, Finger finger) {
  const HandParameters p = checked(parameters);
  const HandBones hand = hand_bones();
  const FingerPad& pad = hand.fingers[static_cast<std::size_t>(finger)].pad;
  const NailBed bed = nail_bed(pad, p);
  const double half_thickness = 0.5 * p.nail_thickness / (p.length / kSkeletonLength);
  // From the middle of the lower face out, round the rim, and back on the upper face.
  std::vector<Loop> loops;
  loops.reserve(2 * (kNailRings + kNailRim) + 1);
  for (int k = 0; k < kNailRings; ++k) {
    loops.push_back(nail_ring(bed, half_thickness, 1.0 * k / kNailRings, -half_thickness));
  }
  std::vector<CurvePoint> rim;
  add_quarter(rim, {-half_thickness, 0.0, half_thickness, 3}, kNailRim);
  rim.pop_back();
  add_quarter(rim, {-half_thickness, 0.0, half_thickness, 0}, kNailRim);
  for (const CurvePoint& point : rim) loops.push_back(nail_ring(bed, -point.u, 1.0, point.v));
  for (int k = kNailRings - 1; k >= 0; --k) {
    loops.push_back(nail_ring(bed, half_thickness, 1.0 * k / kNailRings, half_thickness));
  }
  TriangleMesh mesh = loft(loops);
  move(mesh, pad.R_G, pad.p_G);
  place(mesh, p, grip(hand));
  return mesh;
}

}  // namespace hapticd
