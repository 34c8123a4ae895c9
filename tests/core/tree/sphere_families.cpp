// See sphere_families.h.
#include "tests/core/tree/sphere_families.h"

#include <cmath>

#include "tests/support/contact_scenes.h"

namespace hapticd::test {
namespace {

std::vector<Sphere> line(int count) {
  std::vector<Sphere> spheres;
  spheres.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) spheres.push_back({{1e-3 * i, 2e-3 * i, -5e-4 * i}, 5e-3});
  return spheres;
}

/// Sphere i around sphere i + 1, each well inside the one before.
std::vector<Sphere> nested(int count) {
  std::vector<Sphere> spheres;
  spheres.reserve(static_cast<std::size_t>(count));
  double r = 1.0;
  double x = 0.0;
  for (int i = 0; i < count; ++i) {
    spheres.push_back({{x, -x, 0.5 * x}, r});
    x += 0.1 * r;
    r *= 0.7;
  }
  return spheres;
}

/// Two heaps of equal spheres far apart, and a few points between.
std::vector<Sphere> heaps(int count) {
  std::vector<Sphere> spheres;
  spheres.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    if (i % 16 == 0) {
      spheres.push_back({{0.01 * i, 0.0, 0.0}, 0.0});
    } else {
      spheres.push_back({{i % 2 == 0 ? -10.0 : 10.0, 0.0, 0.0}, 0.02});
    }
  }
  return spheres;
}

/// Radii over fifteen decades.
std::vector<Sphere> all_sizes(SplitMix64& random, int count) {
  std::vector<Sphere> spheres = random_cluster(random, count, 0.5, 0.0, 0.0);
  for (Sphere& sphere : spheres) sphere.r = std::pow(10.0, random.uniform(-14.0, 1.0));
  return spheres;
}

}  // namespace

std::vector<SphereFamily> sphere_families(int count, std::uint64_t seed) {
  SplitMix64 random(seed);
  const int side = 1 + static_cast<int>(std::sqrt(static_cast<double>(count)));
  const auto n = static_cast<std::size_t>(count);
  return {{"cluster", random_cluster(random, count, 0.1, 0.0, 0.02)},
          {"points", random_cluster(random, count, 0.1, 0.0, 0.0)},
          {"blob", blob_spheres(count)},
          {"slab", slab_spheres(side, side)},
          {"line", line(count)},
          {"equal spheres", std::vector<Sphere>(n, Sphere{{0.1, -0.2, 0.3}, 0.01})},
          {"equal points", std::vector<Sphere>(n, Sphere{{0.1, -0.2, 0.3}, 0.0})},
          {"heaps", heaps(count)},
          {"nested", nested(count)},
          {"all sizes", all_sizes(random, count)}};
}

std::vector<Sphere> scaled_and_moved(const std::vector<Sphere>& spheres, double unit,
                                     const Vector3& p) {
  std::vector<Sphere> result;
  result.reserve(spheres.size());
  for (const Sphere& sphere : spheres) result.push_back({sphere.p * unit + p, sphere.r * unit});
  return result;
}

}  // namespace hapticd::test
