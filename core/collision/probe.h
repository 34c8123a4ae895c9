// What a tree is tested against: a capsule or a sphere in the tree's frame, inflated by its radius
// and by the slack that makes every test conservative with respect to rounding. RT: yes.
#pragma once

#include <limits>

#include "core/collision/primitive_gap.h"
#include "core/geometry/sphere_tree_view.h"

namespace hapticd {

/// Rounding error of a tree test relative to the lengths it is computed from. Test and exact gap
/// each lose less than 50 units in the last place of the largest length (three rotations, a
/// projection, a root). Normal value 128 epsilon = 2.8e-14 (7e-12 m in a scene of 250 m); smaller
/// could miss a contact, larger only visits more nodes.
inline constexpr double kRelativeSlack = 128.0 * std::numeric_limits<double>::epsilon();

/// A capsule in the tool's frame.
struct CapsuleProbe {
  Vector3 p_A;
  Vector3 axis;          ///< B - A
  Vector3 axis_inverse;  ///< axis / |axis|^2; 0 when A == B
  double inflation;      ///< radius plus slack, m
};

/// A sphere in the frame of the tree it is tested against.
struct SphereProbe {
  Vector3 p;
  double inflation;  ///< radius plus slack, m
};

/// How far the surface of a query that stops at `last_level` may stick out of the bounds above it,
/// m.
[[nodiscard]] inline double surface_overhang(const SphereTreeView& tree, int last_level) noexcept {
  return last_level < tree.depth ? tree.overhang : 0.0;
}

/// `capsule` in the frame of a tool that reaches `reach` from its origin, and whose surface
/// sticks out of its bounds by at most `overhang`.
[[nodiscard]] inline CapsuleProbe probe_capsule(const PlacedCapsule& capsule, const Matrix3& R_WG,
                                                double reach, double overhang) noexcept {
  const Vector3 axis_W = capsule.p_GB_W - capsule.p_GA_W;
  const double axis_length = length(axis_W);
  const double extent = length(capsule.p_GA_W) + axis_length + reach + capsule.r;
  CapsuleProbe probe{R_WG.transpose() * capsule.p_GA_W, R_WG.transpose() * axis_W, Vector3::Zero(),
                     (capsule.r + overhang) + kRelativeSlack * extent};
  if (axis_length >= kMinLength) probe.axis_inverse = probe.axis / axis_length / axis_length;
  return probe;
}

}  // namespace hapticd
