// Distance functions of round solids and their smooth union: what a hand is made of. Negative
// inside, m. No libm but sqrt. Offline, though nothing here allocates.
#pragma once

#include "server/model/packing/triangle_mesh.h"

namespace hapticd {

/// The hull of two spheres.
struct RoundCone {
  Vector3 p_a{0.0, 0.0, 0.0};  ///< m
  Vector3 p_b{0.0, 0.0, 0.0};
  double r_a = 0.0;  ///< m, >= 0
  double r_b = 0.0;
};

/// Exact distance from the hull's surface, negative inside; exact to rounding. Where one sphere
/// contains the other, that sphere's.
[[nodiscard]] double distance(const RoundCone& cone, const Vector3& p) noexcept;

/// Union of two solids with their seam filled: min(a, b) less up to `blend` / 4 where they differ
/// by less than `blend` (m, > 0). Never above the minimum, grows with both, continuous with its
/// slope; the quadratic polynomial of I. Quilez. Distances that go in need not be exact.
[[nodiscard]] double smooth_minimum(double a, double b, double blend) noexcept;

}  // namespace hapticd
