// The builder of sphere-trees: conservative at every level in exact arithmetic, complete, shallow,
// and strict about its input. Truth: the leaf spheres themselves, long double.
#include "core/tree/sphere_tree.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

#include "tests/core/tree/sphere_families.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/tree_inspector.h"

namespace hapticd::test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void check_tree(const std::vector<Sphere>& spheres) {
  const SphereTree tree = build_sphere_tree(spheres);
  const SphereTreeView view = tree.view();
  const TreeInspector inspector(view, spheres);
  REQUIRE(inspector.well_formed());
  REQUIRE(inspector.complete());
  REQUIRE(inspector.worst_leaf() <= 0.0L);
  REQUIRE(inspector.deepest() == view.depth);
  REQUIRE(view.depth <= kMaxTreeDepth);
}

/// What build_sphere_tree says about `spheres`; "" when it builds.
std::string complaint(const std::vector<Sphere>& spheres) {
  try {
    static_cast<void>(build_sphere_tree(spheres));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("every bound at every level contains all leaves below it, for every family of spheres") {
  SplitMix64 random(1);
  for (std::int64_t trial = 0; trial < scaled(100); ++trial) {
    const int count = 1 + static_cast<int>(random.below(trial % 10 == 0 ? 2000 : 200));
    for (const SphereFamily& family : sphere_families(count, random.next())) {
      CAPTURE(family.name);
      CAPTURE(count);
      check_tree(family.spheres);
    }
  }
}

TEST_CASE("trees stay conservative in any unit and far from the origin") {
  for (const SphereFamily& family : sphere_families(150, 2)) {
    for (const double unit : {1e-100, 1e-6, 1e-3, 1e3, 1e6, 1e100}) {
      for (const double far : {0.0, 1.0, 1e3, 1e6, 1e12}) {
        CAPTURE(family.name);
        CAPTURE(unit);
        CAPTURE(far);
        check_tree(scaled_and_moved(family.spheres, unit, far * unit * Vector3(1.0, -0.7, 0.3)));
      }
    }
  }
}

TEST_CASE("every number of leaves is taken in, with the fewest levels that hold them") {
  std::vector<int> counts(150);
  std::iota(counts.begin(), counts.end(), 1);
  counts.insert(counts.end(), {511, 512, 513, 4096, 4097, 10'000});
  int levels = 1;
  std::size_t capacity = kTreeWidth;
  for (const int count : counts) {
    CAPTURE(count);
    while (capacity < static_cast<std::size_t>(count)) {
      capacity *= kTreeWidth;
      ++levels;
    }
    const std::vector<Sphere> spheres = blob_spheres(count);
    check_tree(spheres);
    const SphereTree tree = build_sphere_tree(spheres);
    CHECK(tree.depth == levels);
    // A node with one child costs as much as one with eight: few may be sparse.
    CHECK(tree.nodes.size() <= static_cast<std::size_t>(1 + count / 7 + levels));
  }
}

TEST_CASE("leaves keep their order and their bits") {
  SplitMix64 random(3);
  const std::vector<Sphere> spheres = random_cluster(random, 300, 0.3, 0.0, 0.1);
  const SphereTree tree = build_sphere_tree(spheres);
  const SphereTreeView view = tree.view();
  REQUIRE(view.leaf_x.size() == spheres.size());
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const Sphere leaf = view.leaf(static_cast<std::int32_t>(i));
    CHECK(leaf.p == spheres[i].p);
    CHECK(leaf.r == spheres[i].r);
  }
}

TEST_CASE("one sphere makes a tree of one node whose bound is that sphere") {
  const SphereTree tree = build_sphere_tree(std::vector<Sphere>{{{1, 2, 3}, 0.5}});
  CHECK(tree.nodes.size() == 1);
  CHECK(tree.depth == 1);
  CHECK(tree.bound.p == Vector3(1, 2, 3));
  CHECK(tree.bound.r == 0.5);
  CHECK(tree.nodes[0].used == 1);
  CHECK(tree.nodes[0].inner == 0);
}

TEST_CASE("the children of the root are eighths of a long set of spheres, whichever way it lies") {
  SplitMix64 random(5);
  for (const Vector3& way :
       {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1), Vector3(0.48, -0.6, 0.64)}) {
    // In no order along the way.
    std::vector<Sphere> spheres;
    spheres.reserve(512);
    for (int i = 0; i < 512; ++i) {
      const double along = i * 199 % 512;
      spheres.push_back({along * way + random_vector(random, 0.5), 0.1});
    }
    const SphereTree tree = build_sphere_tree(spheres);
    const double whole = 0.5 * 511;
    CHECK(tree.bound.r <= 1.02 * (whole + 1.0));
    for (std::size_t k = 0; k < kTreeWidth; ++k) CHECK(tree.nodes[0].r[k] <= whole / 8.0 + 2.0);
  }
}

TEST_CASE("the box of a node is the smallest that holds every leaf below it") {
  SplitMix64 random(77);
  for (int trial = 0; trial < 30; ++trial) {
    const std::vector<Sphere> leaves =
        random_cluster(random, 1 + static_cast<int>(random.below(300)), 0.2, 0.0, 0.02);
    const SphereTree tree = build_sphere_tree(leaves);
    REQUIRE(tree.boxes.size() == tree.nodes.size());
    // Leaves below each node, from the last node on.
    std::vector<std::vector<std::int32_t>> below(tree.nodes.size());
    for (std::size_t n = tree.nodes.size(); n-- > 0;) {
      for (const std::int32_t child : tree.nodes[n].child) {
        if (child == kNoChild) continue;
        if (child < 0) {
          below[n].push_back(~child);
        } else {
          const auto& more = below[static_cast<std::size_t>(child)];
          below[n].insert(below[n].end(), more.begin(), more.end());
        }
      }
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        double lower = 1.0;
        double upper = -1.0;
        for (const std::int32_t leaf : below[n]) {
          const Sphere& sphere = leaves[static_cast<std::size_t>(leaf)];
          lower = std::min(lower, sphere.p[axis] - sphere.r);
          upper = std::max(upper, sphere.p[axis] + sphere.r);
        }
        CHECK(tree.boxes[n].lower[axis] == lower);
        CHECK(tree.boxes[n].upper[axis] == upper);
      }
    }
    CHECK(tree.view().boxes.data() == tree.boxes.data());
  }
}

TEST_CASE("the overhang is how far any bound sticks out of any bound above it") {
  SplitMix64 random(6);
  double largest = 0.0;
  for (const int count : {1, 8, 9, 100, 700}) {
    for (const SphereFamily& family : sphere_families(count, random.next())) {
      CAPTURE(family.name);
      CAPTURE(count);
      const SphereTree tree = build_sphere_tree(family.spheres);
      // Every bound with all that is below it, from the top: lists of bounds above each node.
      std::vector<std::vector<Sphere>> above(tree.nodes.size());
      above[0] = {tree.bound};
      double truth = 0.0;
      for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
        for (std::size_t k = 0; k < kTreeWidth; ++k) {
          const SphereTreeNode& node = tree.nodes[n];
          if (node.child[k] < 0) continue;
          const Sphere bound{{node.x[k], node.y[k], node.z[k]}, node.r[k]};
          for (const Sphere& wider : above[n])
            truth = std::max(truth, (bound.p - wider.p).norm() + bound.r - wider.r);
          auto& below = above[static_cast<std::size_t>(node.child[k])];
          below = above[n];
          below.push_back(bound);
        }
      }
      CHECK(std::abs(tree.overhang - truth) <= 1e-14 * reach(tree.view()));
      CHECK(tree.view().overhang == tree.overhang);
      if (tree.depth == 1) CHECK(tree.overhang == 0.0);
      largest = std::max(largest, tree.overhang / reach(tree.view()));
    }
  }
  CHECK(largest > 1e-3);
}

TEST_CASE("the same spheres give the same tree to the bit") {
  for (const SphereFamily& family : sphere_families(200, 4)) {
    const SphereTree a = build_sphere_tree(family.spheres);
    const SphereTree b = build_sphere_tree(family.spheres);
    REQUIRE(a.nodes.size() == b.nodes.size());
    CHECK(a.bound.p == b.bound.p);
    for (std::size_t n = 0; n < a.nodes.size(); ++n) {
      CHECK(a.nodes[n].child == b.nodes[n].child);
      CHECK(a.nodes[n].x == b.nodes[n].x);
      CHECK(a.nodes[n].r == b.nodes[n].r);
    }
  }
}

TEST_CASE("no spheres are refused") { CHECK(complaint({}).find("no leaf") != std::string::npos); }

TEST_CASE("a centre or radius that is no ordinary number is refused, naming the leaf") {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Sphere> good(5, Sphere{{0.1, 0.2, 0.3}, 0.01});
  CHECK(complaint(good).empty());
  for (const std::size_t bad : {std::size_t{0}, std::size_t{3}, std::size_t{4}}) {
    const std::string name = "leaf " + std::to_string(bad);
    CAPTURE(name);
    for (const double value : {kNaN, kInfinity, -kInfinity, 1e308, -1e200}) {
      for (Eigen::Index k = 0; k < 3; ++k) {
        std::vector<Sphere> spheres = good;
        spheres[bad].p[k] = value;
        CHECK(complaint(spheres).find(name) != std::string::npos);
      }
      std::vector<Sphere> spheres = good;
      spheres[bad].r = value;
      CHECK(complaint(spheres).find(name) != std::string::npos);
    }
    for (const double r : {-1e-300, -std::numeric_limits<double>::denorm_min(), -1.0}) {
      std::vector<Sphere> spheres = good;
      spheres[bad].r = r;
      CHECK(complaint(spheres).find(name) != std::string::npos);
    }
  }
}

TEST_CASE("zero, negative zero and denormal radii and the largest coordinates are taken") {
  for (const double r : {0.0, -0.0, std::numeric_limits<double>::denorm_min(), 1e150}) {
    CHECK(complaint({{{0, 0, 0}, r}, {{1, 0, 0}, r}, {{-1e150, 1e150, 1e150}, r}}).empty());
  }
  check_tree({{{1e150, 1e150, 1e150}, 0.0}, {{-1e150, -1e150, -1e150}, 1e149}, {{0, 0, 0}, 1e150}});
}

}  // namespace hapticd::test
