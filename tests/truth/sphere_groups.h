// Spheres that follow each other, bundled in balls: where a ball is far from something, all of its
// spheres are, and an exhaustive search need not look at them one by one. Frame: that of the
// spheres. SI. Not RT.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/sphere.h"
#include "core/math/pose.h"

namespace hapticd {

/// The spheres begin to end - 1, all of them within the ball.
struct SphereGroup {
  std::size_t begin = 0;
  std::size_t end = 0;
  Sphere ball;
};

/// Every sphere in one group, in order. Good where neighbours in the list are neighbours in space,
/// as the leaves of a sphere-tree are. Cost: one look at each sphere.
[[nodiscard]] std::vector<SphereGroup> group_spheres(std::span<const Sphere> spheres);

/// Calls visit(i) for every sphere, in order, but those of groups whose ball at X is `far`.
template <typename Far, typename Visit>
void visit_spheres(std::span<const SphereGroup> groups, const Pose& X, const Far& far,
                   const Visit& visit) {
  for (const SphereGroup& group : groups) {
    if (far(Sphere{transform(X, group.ball.p), group.ball.r})) continue;
    for (std::size_t i = group.begin; i < group.end; ++i) visit(i);
  }
}

}  // namespace hapticd
