// Reading a sphere-tree: ids of leaves and bounds, the reach from the origin. The tree is laid out
// by hand, so that the builder has no say in it.
#include "core/geometry/sphere_tree_view.h"

#include <doctest/doctest.h>

#include <limits>
#include <set>
#include <vector>

#include "tests/support/contact_scenes.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// Three nodes whose slots all hold different spheres, and five leaves.
struct HandMadeTree {
  std::vector<SphereTreeNode> nodes;
  std::vector<double> x, y, z, r;

  HandMadeTree() {
    for (int n = 0; n < 3; ++n) {
      SphereTreeNode node{};
      for (std::size_t k = 0; k < kTreeWidth; ++k) {
        const double tag = 10.0 * n + static_cast<double>(k);
        node.x[k] = tag;
        node.y[k] = -tag;
        node.z[k] = tag + 0.5;
        node.r[k] = tag + 0.25;
      }
      nodes.push_back(node);
    }
    for (int i = 0; i < 5; ++i) {
      x.push_back(100.0 + i);
      y.push_back(200.0 + i);
      z.push_back(300.0 + i);
      r.push_back(i);
    }
  }
  [[nodiscard]] SphereTreeView view() const { return {nodes, x, y, z, r, {}, 2}; }
};

}  // namespace

TEST_CASE("an id that is not negative names a leaf in the order given") {
  const HandMadeTree tree;
  for (int i = 0; i < 5; ++i) {
    const Sphere sphere = tree_sphere(tree.view(), i);
    CHECK(sphere.p == Vector3(100.0 + i, 200.0 + i, 300.0 + i));
    CHECK(sphere.r == i);
    CHECK(tree.view().leaf(i).p == sphere.p);
    CHECK(tree.view().leaf(i).r == sphere.r);
  }
}

TEST_CASE("the id of a bound names that slot of that node") {
  const HandMadeTree tree;
  for (int n = 0; n < 3; ++n) {
    for (int slot = 0; slot < kTreeWidth; ++slot) {
      const double tag = 10.0 * n + slot;
      const Sphere sphere = tree_sphere(tree.view(), bound_id(n, slot));
      CHECK(sphere.p == Vector3(tag, -tag, tag + 0.5));
      CHECK(sphere.r == tag + 0.25);
    }
  }
}

TEST_CASE("ids of bounds are negative, distinct and fill their range to the last") {
  std::set<TreeSphereId> seen;
  for (int n = 0; n < 1000; ++n) {
    for (int slot = 0; slot < kTreeWidth; ++slot) {
      const TreeSphereId id = bound_id(n, slot);
      CHECK(id < 0);
      CHECK(seen.insert(id).second);
    }
  }
  constexpr std::int32_t kLastNode = std::numeric_limits<std::int32_t>::max() / kTreeWidth;
  CHECK(bound_id(kLastNode, kTreeWidth - 1) == std::numeric_limits<std::int32_t>::min());
}

TEST_CASE("no point of the bound is farther from the origin than the reach, and one is as far") {
  SplitMix64 random(1);
  for (std::int64_t i = 0; i < scaled(100'000); ++i) {
    SphereTreeView tree;
    tree.bound = {random_vector(random, 2.0), random.uniform(0.0, 3.0)};
    const std::array<double, 3> d = random.direction();
    const Vector3 p = tree.bound.p + tree.bound.r * Vector3(d[0], d[1], d[2]);
    REQUIRE(p.norm() <= reach(tree) * (1.0 + 1e-15) + 1e-15);
    const Vector3 farthest = tree.bound.p * (1.0 + tree.bound.r / tree.bound.p.norm());
    REQUIRE(std::abs(farthest.norm() - reach(tree)) <= 1e-14);
  }
  CHECK(reach(SphereTreeView{}) == 0.0);
}

TEST_CASE("the mark of an unused slot names no node and no leaf that a tree can hold") {
  CHECK(kNoChild < 0);
  CHECK(~kNoChild == std::numeric_limits<std::int32_t>::max());
}

}  // namespace hapticd::test
