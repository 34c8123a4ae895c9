// See enclosing_sphere.h.
#include "core/tree/enclosing_sphere.h"

#include <algorithm>
#include <limits>

#include "core/geometry/closest_point.h"

namespace hapticd {
namespace {

/// Steps of the iteration: the k-th moves the centre by 1/(k + 1) of the way to the farthest
/// sphere. Normal value 100 (about 1 % from the optimum); fewer gives looser bounds, so slower
/// queries.
constexpr int kIterations = 100;
/// Relative rounding of one distance plus radius: three roundings below the root, the root, the
/// sum, and one of the product that applies it; doubled. Smaller could let a leaf stick out by an
/// ulp.
constexpr double kRoundUp = 1.0 + 12.0 * std::numeric_limits<double>::epsilon();

struct Farthest {
  double reach;  ///< largest distance plus radius, m, rounded to nearest
  std::int32_t member;
};

Farthest farthest(std::span<const Sphere> spheres, std::span<const std::int32_t> members,
                  const Vector3& p_C) noexcept {
  Farthest result{-1.0, 0};
  for (const std::int32_t i : members) {
    const Sphere& sphere = spheres[static_cast<std::size_t>(i)];
    const double reach = length(sphere.p - p_C) + sphere.r;
    if (reach > result.reach) result = {reach, i};
  }
  return result;
}

Vector3 centre_of_box(std::span<const Sphere> spheres,
                      std::span<const std::int32_t> members) noexcept {
  const Sphere& first = spheres[static_cast<std::size_t>(members.front())];
  Vector3 low = first.p.array() - first.r;
  Vector3 high = first.p.array() + first.r;
  for (const std::int32_t i : members) {
    const Sphere& sphere = spheres[static_cast<std::size_t>(i)];
    low = low.array().min(sphere.p.array() - sphere.r);
    high = high.array().max(sphere.p.array() + sphere.r);
  }
  return 0.5 * low + 0.5 * high;
}

}  // namespace

Sphere enclosing_sphere(std::span<const Sphere> spheres,
                        std::span<const std::int32_t> members) noexcept {
  if (members.size() == 1) return spheres[static_cast<std::size_t>(members.front())];
  Vector3 p_C = centre_of_box(spheres, members);
  Farthest far = farthest(spheres, members, p_C);
  Sphere best{p_C, far.reach};
  for (int k = 1; k <= kIterations; ++k) {
    // The farthest point of the farthest sphere, not its centre, is what the centre moves to.
    const Sphere& sphere = spheres[static_cast<std::size_t>(far.member)];
    const Vector3 to_centre = sphere.p - p_C;
    const double distance = length(to_centre);
    if (distance <= 0.0) break;
    p_C += to_centre * (far.reach / distance / (k + 1.0));
    far = farthest(spheres, members, p_C);
    if (far.reach < best.r) best = {p_C, far.reach};
  }
  // kMinLength covers distances whose squares vanish.
  best.r = best.r * kRoundUp + 4.0 * kMinLength;
  return best;
}

}  // namespace hapticd
