// Sets of spheres that make a bounding hierarchy fail: clouds, slabs, lines, heaps of equal
// spheres, spheres within spheres, points, far from the origin, in any unit. Lengths in m.
#pragma once

#include <string>
#include <vector>

#include "core/geometry/sphere.h"

namespace hapticd::test {

struct SphereFamily {
  std::string name;
  std::vector<Sphere> spheres;
};

/// Every family, of about `count` spheres each, from `seed`.
[[nodiscard]] std::vector<SphereFamily> sphere_families(int count, std::uint64_t seed);

/// `spheres` with all lengths times `unit`, then moved by `p`.
[[nodiscard]] std::vector<Sphere> scaled_and_moved(const std::vector<Sphere>& spheres, double unit,
                                                   const Vector3& p);

}  // namespace hapticd::test
