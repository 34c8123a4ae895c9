// The blended surface of a body: the equation that defines it, solved here by halving over all
// leaves in long double, and what follows from it. Clouds of spheres from a fixed seed and from one
// of the run.
#include "core/collision/blended_surface.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "tests/core/collision/scene_check.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

std::vector<std::uint64_t> seeds() {
  const std::uint64_t fresh = std::random_device{}();
  MESSAGE("the new seed of this run is ", fresh);
  return {71, fresh};
}

SphereTree blended(const std::vector<Sphere>& leaves, double width) {
  SphereTree tree = build_sphere_tree(leaves);
  blend_surface(width, tree);
  return tree;
}

/// phi at p, by halving between its bounds.
double exact_phi(const std::vector<Sphere>& leaves, double width, const Vector3& p) {
  std::vector<long double> d;
  for (const Sphere& leaf : leaves) {
    long double square = 0.0L;
    for (int k = 0; k < 3; ++k) {
      const long double x = static_cast<long double>(p[k]) - static_cast<long double>(leaf.p[k]);
      square += x * x;
    }
    d.push_back(std::sqrt(square) - static_cast<long double>(leaf.r));
  }
  long double high = *std::min_element(d.begin(), d.end());
  long double low = high - static_cast<long double>(width);
  for (int i = 0; i < 80; ++i) {
    const long double middle = 0.5L * (low + high);
    long double sum = 0.0L;
    for (const long double one : d) {
      const long double s = 1.0L - (one - middle) / static_cast<long double>(width);
      if (s > 0.0L) sum += s * s * s;
    }
    (sum > 1.0L ? high : low) = middle;
  }
  return static_cast<double>(low);
}

/// Leaves in a flat sheet or a heap, and a width of about their distance.
struct Cloud {
  std::vector<Sphere> leaves;
  double width;
};

Cloud random_cloud(SplitMix64& random) {
  if (random.chance(0.5)) return {slab_spheres(20, 10), random.uniform(2e-4, 4e-3)};
  return {random_cluster(random, 300, 0.2, 0.0, 0.02), random.uniform(1e-4, 0.02)};
}

/// The gradient of phi by differences over `h` (m).
Vector3 gradient_by_differences(const Cloud& cloud, const Vector3& p, double h) {
  Vector3 gradient;
  for (int k = 0; k < 3; ++k) {
    Vector3 step = Vector3::Zero();
    step[k] = h;
    gradient[k] = (exact_phi(cloud.leaves, cloud.width, p + step) -
                   exact_phi(cloud.leaves, cloud.width, p - step)) /
                  (2.0 * h);
  }
  return gradient;
}

/// Somewhere outside a leaf, mostly near.
Vector3 beside(const Cloud& cloud, SplitMix64& random) {
  const Sphere& leaf = cloud.leaves[random.below(cloud.leaves.size())];
  const double away = random.chance(0.8) ? random.uniform(0.0, 5e-3) : random.uniform(0.0, 0.2);
  return leaf.p + (leaf.r + away) * random_vector(random, 1.0).normalized();
}

/// The gap of each tool sphere, for a tool at X_WG and a body at X_WB, by looking at everything.
struct Placed {
  Pose X_WG;
  Pose X_WB;
};

std::vector<double> exact_gaps(const std::vector<Sphere>& tool, const Placed& placed,
                               const Cloud& cloud) {
  std::vector<double> gaps;
  for (const Sphere& sphere : tool) {
    const Vector3 p_B = transform(inverse(placed.X_WB), transform(placed.X_WG, sphere.p));
    gaps.push_back(exact_phi(cloud.leaves, cloud.width, p_B) - sphere.r);
  }
  return gaps;
}

}  // namespace

TEST_CASE("the distance from a blended surface is the root of its equation, below every leaf's") {
  for (const std::uint64_t seed : seeds()) {
    SplitMix64 random(seed);
    std::int64_t blends = 0;
    for (std::int64_t trial = 0; trial < scaled(1000); ++trial) {
      const Cloud cloud = random_cloud(random);
      const SphereTree tree = blended(cloud.leaves, cloud.width);
      for (int k = 0; k < 10; ++k) {
        const Vector3 p = beside(cloud, random);
        const double phi = place_beside_blend(tree.view(), p).distance;
        REQUIRE(std::abs(phi - exact_phi(cloud.leaves, cloud.width, p)) < 1e-13);
        double least = 1e9;
        for (const Sphere& leaf : cloud.leaves) {
          least = std::min(least, (p - leaf.p).norm() - leaf.r);
        }
        REQUIRE(phi <= least + 1e-15);
        REQUIRE(phi > least - cloud.width);
        blends += phi < least - 0.01 * cloud.width ? 1 : 0;
      }
    }
    CHECK(blends > scaled(1000));
  }
}

TEST_CASE("normal and curvature of a blended surface are those of the gradient of its distance") {
  for (const std::uint64_t seed : seeds()) {
    SplitMix64 random(seed);
    std::int64_t judged = 0;
    for (std::int64_t trial = 0; trial < scaled(1000); ++trial) {
      const Cloud cloud = random_cloud(random);
      const SphereTree tree = blended(cloud.leaves, cloud.width);
      const Vector3 p = beside(cloud, random);
      const double h = 1e-3 * cloud.width;
      const Vector3 gradient = gradient_by_differences(cloud, p, h);
      REQUIRE(gradient.norm() < 1.0 + 1e-9);
      if (gradient.norm() < 0.2) continue;
      const BlendedPlace place = place_beside_blend(tree.view(), p);
      const Vector3 fine = gradient_by_differences(cloud, p, 0.01 * h);
      const Vector3 n = fine.normalized();
      REQUIRE((place.nhat_B - n).norm() < 1e-3);
      // Where another leaf begins to count the curvature steps, and no difference across tells it.
      if ((fine - gradient).norm() > 1e-4) continue;
      ++judged;
      Matrix3 turns;
      for (int k = 0; k < 3; ++k) {
        Vector3 step = Vector3::Zero();
        step[k] = h;
        turns.col(k) = (gradient_by_differences(cloud, p + step, h) -
                        gradient_by_differences(cloud, p - step, h)) /
                       (2.0 * h * gradient.norm());
      }
      const Matrix3 across = Matrix3::Identity() - n * n.transpose();
      const Matrix3 exact = across * turns * across;
      REQUIRE((place.curvature_B - exact).norm() < 0.02 * (exact.norm() + 1.0 / cloud.width));
      REQUIRE((place.curvature_B * place.nhat_B).norm() < 1e-9 / cloud.width);
    }
    CHECK(2 * judged > scaled(1000));
  }
}

TEST_CASE("what is remembered of a blended surface changes no bit, wherever the tool goes") {
  for (const std::uint64_t seed : seeds()) {
    SplitMix64 random(seed);
    auto memory = std::make_unique<BlendMemory>();
    std::vector<SphereTree> trees;
    std::vector<Cloud> clouds;
    for (int k = 0; k < 3; ++k) {
      clouds.push_back(random_cloud(random));
      trees.push_back(blended(clouds.back().leaves, clouds.back().width));
    }
    for (std::int64_t walk = 0; walk < scaled(1000); ++walk) {
      const std::size_t k = random.below(3);
      Vector3 p = beside(clouds[k], random);
      const double step = clouds[k].width * random.uniform(0.0, 0.3);
      for (int i = 0; i < 20; ++i) {
        const auto sphere = static_cast<TreeSphereId>(random.below(2));
        const BlendedPlace with = place_beside_blend(trees[k].view(), p, &memory->around(sphere));
        const BlendedPlace without = place_beside_blend(trees[k].view(), p);
        REQUIRE(with.distance == without.distance);
        REQUIRE(with.nhat_B == without.nhat_B);
        REQUIRE(with.curvature_B == without.curvature_B);
        if (random.chance(0.7)) p += random_vector(random, step);
      }
    }
  }
}

TEST_CASE("a query finds each tool sphere near a blended surface once, and the smallest gap") {
  for (const std::uint64_t seed : seeds()) {
    SplitMix64 random(seed);
    std::size_t found = 0;
    // Most tools are far away.
    const std::int64_t trials = std::max<std::int64_t>(30, scaled(300));
    for (std::int64_t trial = 0; trial < trials; ++trial) {
      const Cloud cloud = random_cloud(random);
      const SphereTree body = blended(cloud.leaves, cloud.width);
      const std::vector<Sphere> spheres = random_cluster(random, 60, 0.05, 0.0, 0.01);
      const SphereTree tool = build_sphere_tree(spheres);
      const Pose X_WB{random_rotation(random), random_vector(random, 0.1)};
      const Pose X_WG{random_rotation(random), random_vector(random, 0.2)};
      QueryOptions options;
      options.margin = random.uniform(1e-4, 0.02);
      const BodyView view{body.view(), X_WB};
      const ToolView placed{tool.view(), X_WG};
      auto set = std::make_unique<ContactSet>();
      find_contacts(placed, {{}, {&view, 1}}, options, *set);
      const std::vector<double> exact = exact_gaps(spheres, {X_WG, X_WB}, cloud);
      const auto near = static_cast<std::size_t>(std::count_if(
          exact.begin(), exact.end(), [&](double gap) { return gap < options.margin; }));
      REQUIRE(std::abs(set->minimum_gap - *std::min_element(exact.begin(), exact.end())) < 1e-12);
      REQUIRE(set->contacts.size() == near);
      for (const Contact& contact : set->contacts) {
        REQUIRE(is_blend(contact.key));
        REQUIRE(std::abs(contact.gap -
                         exact.at(static_cast<std::size_t>(contact.key.tool_sphere))) < 1e-12);
      }
      found += near;
      // Evaluated one by one and all together elsewhere.
      const Pose X_moved{X_WG.q, X_WG.p + random_vector(random, 1e-3)};
      const ToolView moved{tool.view(), X_moved};
      evaluate_contacts(moved, {{}, {&view, 1}}, *set);
      const std::vector<double> there = exact_gaps(spheres, {X_moved, X_WB}, cloud);
      for (const Contact& contact : set->contacts) {
        const Contact alone = evaluate_contact(contact.key, moved, {{}, {&view, 1}});
        REQUIRE(std::abs(contact.gap -
                         there.at(static_cast<std::size_t>(contact.key.tool_sphere))) < 1e-12);
        REQUIRE(std::abs(alone.gap - contact.gap) < 1e-14);
        REQUIRE((alone.nhat_OG_W - contact.nhat_OG_W).norm() < 1e-12);
        REQUIRE((alone.p_WC - contact.p_WC).norm() < 1e-12);
      }
    }
    CHECK(found > static_cast<std::size_t>(trials));
  }
}

TEST_CASE("a query of a coarse level never says that a blended surface is farther than it is") {
  SplitMix64 random(73);
  for (std::int64_t trial = 0; trial < scaled(500); ++trial) {
    const Cloud cloud = random_cloud(random);
    const SphereTree body = blended(cloud.leaves, cloud.width);
    const std::vector<Sphere> spheres{{{0.0, 0.0, 0.0}, random.uniform(1e-3, 0.01)}};
    const SphereTree tool = build_sphere_tree(spheres);
    const Pose X_WG{{1.0, 0.0, 0.0, 0.0}, beside(cloud, random)};
    QueryOptions options;
    options.margin = random.uniform(1e-4, 0.02);
    options.body_level = 1;
    const BodyView view{body.view(), {}};
    auto set = std::make_unique<ContactSet>();
    find_contacts({tool.view(), X_WG}, {{}, {&view, 1}}, options, *set);
    const double exact = exact_gaps(spheres, {X_WG, {}}, cloud).front();
    REQUIRE(set->minimum_gap <= exact + 1e-14);
  }
}

}  // namespace hapticd::test
