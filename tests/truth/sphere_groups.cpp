// See sphere_groups.h.
#include "tests/truth/sphere_groups.h"

#include <algorithm>

namespace hapticd {
namespace {

/// Spheres of a group. Smaller: more balls to look at; larger: more spheres behind each.
constexpr std::size_t kSize = 16;
/// Widens each ball, so that rounding lets no sphere stick out of it.
constexpr double kRounding = 1e-9;

}  // namespace

std::vector<SphereGroup> group_spheres(std::span<const Sphere> spheres) {
  std::vector<SphereGroup> groups;
  groups.reserve(spheres.size() / kSize + 1);
  for (std::size_t begin = 0; begin < spheres.size(); begin += kSize) {
    const std::size_t end = std::min(begin + kSize, spheres.size());
    Vector3 lower = spheres[begin].p;
    Vector3 upper = lower;
    for (std::size_t i = begin; i < end; ++i) {
      lower = lower.cwiseMin(spheres[i].p);
      upper = upper.cwiseMax(spheres[i].p);
    }
    Sphere ball{0.5 * (lower + upper), 0.0};
    for (std::size_t i = begin; i < end; ++i) {
      ball.r = std::max(ball.r, (spheres[i].p - ball.p).norm() + spheres[i].r);
    }
    ball.r += kRounding * (ball.r + ball.p.norm());
    groups.push_back({begin, end, ball});
  }
  return groups;
}

}  // namespace hapticd
