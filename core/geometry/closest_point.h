// Closest point of a segment to a point (Eq. 2-3 with the division by |AB|^2 that the printed Eq. 2
// lacks). The offset is computed as C - (A + lambda AB), accurate to |AB| / r = 1e7. Lengths
// between kMinLength and 1e150 m have squares that neither vanish nor overflow; shorter ones
// count as 0. RT: yes, about 5 ns.
#pragma once

#include <cmath>

#include "core/math/vector.h"

namespace hapticd {

/// Lengths below this count as 0, m: their squares leave the normal range. Normal value 1e-150;
/// larger would turn small units of length into coincident points.
inline constexpr double kMinLength = 1e-150;

struct SegmentPoint {
  double lambda;    ///< position along AB in [0, 1]; 0 when A == B
  Vector3 p;        ///< the point A + lambda AB
  Vector3 offset;   ///< C - p
  double distance;  ///< |offset|
};

/// Length of `v`, m, summed in a fixed order.
[[nodiscard]] inline double length(const Vector3& v) noexcept {
  return std::sqrt((v.x() * v.x() + v.y() * v.y()) + v.z() * v.z());
}

/// Point of segment AB nearest to C. All finite; coordinates up to 1e150.
[[nodiscard]] inline SegmentPoint closest_point_on_segment(const Vector3& p_A, const Vector3& p_B,
                                                           const Vector3& p_C) noexcept {
  const Vector3 AB = p_B - p_A;
  const Vector3 AC = p_C - p_A;
  const double length_squared = (AB.x() * AB.x() + AB.y() * AB.y()) + AB.z() * AB.z();
  double lambda = 0.0;
  if (length_squared >= kMinLength * kMinLength) {
    lambda = ((AC.x() * AB.x() + AC.y() * AB.y()) + AC.z() * AB.z()) / length_squared;
    lambda = lambda > 0.0 ? lambda : 0.0;
    lambda = lambda < 1.0 ? lambda : 1.0;
  }
  const Vector3 offset = AC - lambda * AB;
  return {lambda, p_A + lambda * AB, offset, length(offset)};
}

/// A fixed unit vector normal to `axis` that depends on the line of `axis` alone; +y when the axis
/// vanishes. About 20 ns.
[[nodiscard]] Vector3 fixed_normal(const Vector3& axis) noexcept;

/// Unit direction of `offset` (length `distance`). When `distance` is 0 (below kMinLength):
/// fixed_normal(axis), so that a centre exactly on a string's axis is always pushed out the same
/// way.
[[nodiscard]] inline Vector3 direction_or_fallback(const Vector3& offset, double distance,
                                                   const Vector3& axis) noexcept {
  if (distance >= kMinLength) [[likely]]
    return offset * (1.0 / distance);
  return fixed_normal(axis);
}

}  // namespace hapticd
