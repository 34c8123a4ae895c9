// find_contacts against exhaustive search on random scenes: every pair, every number, the minimum
// gap. Set equality is checked with the tolerance of double rounding at the margin only.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/collision/query.h"
#include "core/tree/sphere_tree.h"
#include "tests/core/collision/scene_check.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// 10^x with x uniform in [low, high].
double decade(SplitMix64& random, double low, double high) {
  return std::pow(10.0, random.uniform(low, high));
}

}  // namespace

TEST_CASE("every pair nearer than the margin and the true minimum gap are found in random scenes") {
  SplitMix64 random(11);
  for (std::int64_t trial = 0; trial < scaled(20000); ++trial) {
    CheckedScene scene;
    const double size = random.uniform(0.01, 0.3);
    scene.set_tool(
        random_cluster(random, 1 + static_cast<int>(random.below(120)), size, 0.0, 0.02));
    for (std::uint64_t k = random.below(8); k > 0; --k) {
      scene.capsules.push_back(
          {random_vector(random, 0.5), random_vector(random, 0.5), random.uniform(0.0, 0.01)});
    }
    for (std::uint64_t k = random.below(3); k > 0; --k) {
      const int count = 1 + static_cast<int>(random.below(300));
      scene.add_body(random_cluster(random, count, random.uniform(0.01, 0.5), 0.0, 0.02),
                     {random_rotation(random), random_vector(random, 0.5)});
    }
    QueryOptions options;
    options.margin = random.uniform(1e-4, 0.03);
    check_against_oracle(scene, {random_rotation(random), random_vector(random, 0.6)}, options);
  }
}

TEST_CASE("many strings and bodies at once are all found") {
  SplitMix64 random(12);
  for (std::int64_t trial = 0; trial < scaled(500); ++trial) {
    CheckedScene scene;
    scene.set_tool(hand_spheres());
    scene.capsules = seven_strings();
    for (int k = 0; k < 20; ++k) {
      scene.capsules.push_back(
          {random_vector(random, 0.5), random_vector(random, 0.5), random.uniform(0.0, 2e-3)});
    }
    scene.add_body(slab_spheres(40, 6), {});
    for (int k = 0; k < 12; ++k) {
      scene.add_body(
          random_cluster(random, 1 + static_cast<int>(random.below(60)), 0.05, 0.0, 5e-3),
          {random_rotation(random), random_vector(random, 0.3)});
    }
    check_against_oracle(scene, {random_rotation(random), random_vector(random, 0.2)}, {});
  }
}

TEST_CASE("large tools against large bodies keep every pair, near and far") {
  SplitMix64 random(13);
  for (std::int64_t trial = 0; trial < scaled(100); ++trial) {
    CheckedScene scene;
    scene.set_tool(blob_spheres(1000));
    scene.capsules = seven_strings();
    scene.add_body(slab_spheres(100, 16), {});
    Pose X_WG{random_rotation(random), random_vector(random, 0.1)};
    X_WG.p.y() = random.uniform(0.03, trial % 4 == 0 ? 3.0 : 0.06);
    check_against_oracle(scene, X_WG, {trial % 2 == 0 ? 2e-4 : 5e-4});
  }
}

TEST_CASE("sizes of strings, tools and bodies that differ by decades lose no pair") {
  SplitMix64 random(14);
  for (std::int64_t trial = 0; trial < scaled(4'000); ++trial) {
    CheckedScene scene;
    const double tool_size = decade(random, -6.0, 1.0);
    scene.set_tool(random_cluster(random, 1 + static_cast<int>(random.below(40)), tool_size, 0.0,
                                  tool_size * decade(random, -4.0, 0.0)));
    for (int k = 0; k < 4; ++k) {
      const Vector3 near = random_vector(random, tool_size);
      const Vector3 way = to_vector(random.direction());
      // One without length, one extremely long; they end near the tool or pass by.
      const double L = k == 0 ? 0.0 : decade(random, -6.0, 7.0);
      const Vector3 p_A = near - (k == 1 ? 0.0 : random.uniform()) * L * way;
      scene.capsules.push_back(
          {p_A, p_A + L * way, random.chance(0.3) ? 0.0 : decade(random, -9, 0)});
    }
    const double body_size = decade(random, -6.0, 2.0);
    scene.add_body(random_cluster(random, 1 + static_cast<int>(random.below(40)), body_size, 0.0,
                                  body_size * decade(random, -4.0, 0.0)),
                   {random_rotation(random), random_vector(random, tool_size)});
    QueryOptions options;
    options.margin = tool_size * decade(random, -3.0, 1.0);
    check_against_oracle(scene, {random_rotation(random), random_vector(random, tool_size)},
                         options);
  }
}

TEST_CASE("scenes far from the world's origin keep their gaps") {
  SplitMix64 random(15);
  for (std::int64_t trial = 0; trial < scaled(2'000); ++trial) {
    SceneParts parts = random_parts(random);
    const Vector3 far = decade(random, 0.0, 8.0) * to_vector(random.direction());
    for (Capsule& capsule : parts.capsules_W) {
      capsule.p_A += far;
      capsule.p_B += far;
    }
    for (SceneParts::Body& body : parts.bodies) body.X_WB.p += far;
    parts.X_WG.p += far;
    // The oracle gets the same rounded scene, so little of the distance enters.
    check_against_oracle(CheckedScene(parts), parts.X_WG, {0.01});
  }
}

TEST_CASE("a tool far beyond everything finds nothing near and the true minimum gap") {
  SplitMix64 random(16);
  for (std::int64_t trial = 0; trial < scaled(2'000); ++trial) {
    SceneParts parts = random_parts(random);
    parts.X_WG.p = decade(random, 0.5, 9.0) * to_vector(random.direction());
    check_against_oracle(CheckedScene(parts), parts.X_WG, {});
  }
}

TEST_CASE("coincident spheres and spheres within spheres are all counted") {
  SplitMix64 random(17);
  for (std::int64_t trial = 0; trial < scaled(500); ++trial) {
    CheckedScene scene;
    const auto count = 1 + random.below(40);
    std::vector<Sphere> tool(count, Sphere{random_vector(random, 0.02), 5e-3});
    std::vector<Sphere> body;
    body.reserve(40);
    for (std::uint64_t k = 0; k < 40; ++k) {
      body.push_back({{1e-3, 2e-3, -1e-3}, 0.05 * random.uniform()});
    }
    scene.set_tool(tool);
    scene.capsules.assign(5, Capsule{{-1, 0, 0}, {1, 0, 0}, 1e-3});
    scene.add_body(body, {random_rotation(random), Vector3::Zero()});
    check_against_oracle(scene, {random_rotation(random), random_vector(random, 0.06)}, {0.02});
  }
}

}  // namespace hapticd::test
