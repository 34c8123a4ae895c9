// The descent keeps just what overlaps, and looks below nothing else. Truth: every leaf.
#include "tests/oracle/descent.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <set>

#include "core/tree/sphere_tree.h"
#include "tests/oracle/json.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

std::vector<Sphere> cloud(SplitMix64& random, int count) {
  std::vector<Sphere> spheres;
  spheres.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    spheres.push_back(
        {{random.uniform(-0.05, 0.05), random.uniform(-0.02, 0.02), random.uniform(-0.1, 0.1)},
         random.uniform(1e-3, 6e-3)});
  }
  return spheres;
}

/// Distance of a point from the line along x through `y`, `z`, which is long enough.
double from_line(const Vector3& p, double y, double z) { return std::hypot(p.y() - y, p.z() - z); }

}  // namespace

TEST_CASE("a descent keeps every leaf that overlaps the string, and each level fewer than it saw") {
  SplitMix64 random(3);
  for (int k = 0; k < scaled(100); ++k) {
    const std::vector<Sphere> leaves = cloud(random, 400);
    const SphereTree tree = build_sphere_tree(leaves);
    const double y = random.uniform(-0.03, 0.03);
    const double z = random.uniform(-0.1, 0.1);
    const Capsule string{{-1.0, y, z}, {1.0, y, z}, 0.34e-3};
    std::set<TreeSphereId> truth;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      if (from_line(leaves[i].p, y, z) < leaves[i].r + 0.34e-3) {
        truth.insert(static_cast<TreeSphereId>(i));
      }
    }
    std::set<TreeSphereId> kept;
    std::size_t expected = 0;
    const Descent descent = descend(tree.view(), {}, string, 0.0);
    for (const auto& level : descent) {
      if (expected > 0) CHECK(level.size() <= 8 * expected);
      expected = 0;
      for (const DescentSphere& sphere : level) {
        if (sphere.kept && sphere.leaf) kept.insert(sphere.id);
        if (sphere.kept && !sphere.leaf) ++expected;
      }
    }
    CHECK(kept == truth);
    CHECK(expected == 0);
  }
}

TEST_CASE("a tool is put as deep into a string as was asked") {
  SplitMix64 random(4);
  const std::vector<Sphere> leaves = cloud(random, 100);
  const SphereTree tree = build_sphere_tree(leaves);
  const Capsule string{{-1.0, 0.3, 0.02}, {1.0, 0.3, 0.02}, 0.34e-3};
  const Vector3 way = way_into(tree.view(), {}, string, 7e-4);
  double deepest = 1.0;
  for (const Sphere& leaf : leaves) {
    deepest = std::min(deepest, from_line(leaf.p + way, 0.3, 0.02) - leaf.r - 0.34e-3);
  }
  // Another sphere may be a little deeper still once the tool has moved.
  CHECK(deepest <= -7e-4 + 1e-12);
  CHECK(deepest > -3e-3);
}

TEST_CASE("JSON keeps every bit of a number and the order, and has what is no number as null") {
  const double odd = std::nextafter(0.1, 1.0);
  const std::string line = text_of({{"b", odd}, {"a", std::numeric_limits<double>::infinity()}});
  CHECK(line.find("{\"b\":") == 0);
  CHECK(line.find(",\"a\":null}") != std::string::npos);
  CHECK(std::strtod(line.c_str() + 5, nullptr) == odd);
  CHECK(text_of({{"a", "x\"y\n\xff"}}) == "{\"a\":\"x\\\"y\\n\xef\xbf\xbd\"}");
}

}  // namespace hapticd::test
