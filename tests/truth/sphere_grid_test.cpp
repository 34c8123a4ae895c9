// The grid hides no sphere. Truth: every sphere looked at.
#include "tests/truth/sphere_grid.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

Vector3 somewhere(SplitMix64& random, double extent) {
  return {random.uniform(-extent, extent), random.uniform(-extent, extent),
          random.uniform(-extent, extent)};
}

}  // namespace

TEST_CASE("a look into the grid misses no sphere that is near enough, whatever their sizes") {
  SplitMix64 random(1);
  for (int scene = 0; scene < scaled(200); ++scene) {
    const double extent = std::pow(10.0, random.uniform(-3.0, 3.0));
    std::vector<Sphere> spheres(1 + random.below(300));
    for (Sphere& sphere : spheres) {
      sphere = {somewhere(random, extent), extent * std::pow(10.0, random.uniform(-4.0, 0.0))};
    }
    const SphereGrid grid(spheres);
    for (int look = 0; look < 20; ++look) {
      const Vector3 p = somewhere(random, 1.2 * extent);
      const double radius = extent * std::pow(10.0, random.uniform(-5.0, 0.5));
      std::set<std::size_t> seen;
      grid.visit_near(p, radius, [&](std::size_t i) { seen.insert(i); });
      const bool nothing_near = grid.nothing_near(p, radius);
      for (std::size_t i = 0; i < spheres.size(); ++i) {
        if ((spheres[i].p - p).norm() - spheres[i].r >= radius) continue;
        REQUIRE(seen.count(i) == 1);
        REQUIRE_FALSE(nothing_near);
      }
    }
  }
}

TEST_CASE("a look into the grid leaves out most of what is far") {
  std::vector<Sphere> spheres;
  spheres.reserve(1000);
  for (int i = 0; i < 1000; ++i) spheres.push_back({{0.01 * i, 0.0, 0.0}, 0.004});
  const SphereGrid grid(spheres);
  std::set<std::size_t> seen;
  grid.visit_near({5.0, 0.0, 0.0}, 0.01, [&](std::size_t i) { seen.insert(i); });
  CHECK(seen.size() <= 8);
  CHECK(grid.nothing_near({5.0, 0.1, 0.0}, 0.05));
}

TEST_CASE("a grid of nothing has nothing") {
  const SphereGrid grid({});
  grid.visit_near({0.0, 0.0, 0.0}, 1.0, [](std::size_t) { CHECK(false); });
}

}  // namespace hapticd::test
