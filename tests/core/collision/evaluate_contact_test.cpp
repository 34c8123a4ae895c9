// One pair again, at another pose of the tool: the oracle's numbers there, and the query's own bits
// at the query's pose.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/core/collision/scene_check.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// The oracle's pair of that key, from all pairs.
const OracleContact& pair_of(const OracleResult& all, const ContactKey& key) {
  const auto found = std::find_if(all.contacts.begin(), all.contacts.end(),
                                  [&](const OracleContact& pair) { return pair.key == key; });
  REQUIRE(found != all.contacts.end());
  return *found;
}

}  // namespace

TEST_CASE("every contact found has the same bits when it is evaluated again at the same pose") {
  SplitMix64 random(1);
  for (std::int64_t trial = 0; trial < scaled(1'000); ++trial) {
    const SceneParts parts = random_parts(random);
    const CheckedScene scene(parts);
    QueryOptions options{0.02};
    options.tool_level = trial % 3 == 0 ? 1 : kLeafLevel;
    options.body_level = trial % 4 == 0 ? 1 : kLeafLevel;
    const auto set = found_contacts(scene, parts.X_WG, options);
    bool same = true;
    for (const Contact& contact : set->contacts) {
      const Contact again =
          evaluate_contact(contact.key, {scene.tool(), parts.X_WG}, scene.obstacles());
      same = same && same_bits(contact, again);
    }
    REQUIRE(same);
    if (!set->contacts.empty())
      REQUIRE(minimum_gap_of(*set, {scene.tool(), parts.X_WG}, scene.obstacles()) ==
              set->minimum_gap);
  }
}

TEST_CASE("all contacts at once have the bits that each has alone, at any pose") {
  SplitMix64 random(3);
  for (std::int64_t trial = 0; trial < scaled(1'000); ++trial) {
    const SceneParts parts = random_parts(random);
    const CheckedScene scene(parts);
    const auto set = found_contacts(scene, parts.X_WG, {0.05});
    const Pose X_WG{random_rotation(random), random_vector(random, 0.3)};
    const std::vector<Contact> before(set->contacts.begin(), set->contacts.end());
    evaluate_contacts({scene.tool(), X_WG}, scene.obstacles(), *set);
    double smallest = std::numeric_limits<double>::infinity();
    bool same = set->contacts.size() == before.size();
    for (std::size_t k = 0; same && k < before.size(); ++k) {
      const Contact alone =
          evaluate_contact(before[k].key, {scene.tool(), X_WG}, scene.obstacles());
      same = same_bits(set->contacts[k], alone);
      smallest = std::min(smallest, alone.gap);
    }
    REQUIRE(same);
    REQUIRE(set->minimum_gap == smallest);
  }
}

TEST_CASE("pairs without direction or length have the same bits all at once and alone") {
  SplitMix64 random(5);
  CheckedScene scene;
  std::vector<Sphere> heap(40, Sphere{{0, 0, 0}, 0.0});
  heap.push_back({{1, 0, 0}, 0.5});
  scene.set_tool(heap);
  scene.capsules = {{{0, 0, 0}, {0, 0, 0}, 0.0},
                    {{-1, 0, 0}, {1, 0, 0}, 0.0},
                    {{0, -1e7, 0}, {0, 1e7, 0}, 1},
                    {{0, 0, 0}, {1e-160, 0, 0}, 0.1},
                    {{0, 0, 0}, {1e-140, 0, 0}, 0.1}};
  scene.add_body({{{0, 0, 0}, 0.0}, {{0, 1, 0}, 0.1}}, {});
  const auto set = found_contacts(scene, {}, {10.0});
  REQUIRE(set->contacts.size() == heap.size() * 7);
  for (const Pose& X_WG : {Pose{}, Pose{{0, 1, 0, 0}, {0, 0, 0}}, Pose{{1, 0, 0, 0}, {-0.0, -1, 0}},
                           Pose{random_rotation(random), random_vector(random, 1e-15)}}) {
    evaluate_contacts({scene.tool(), X_WG}, scene.obstacles(), *set);
    for (const Contact& contact : set->contacts) {
      REQUIRE(same_bits(contact,
                        evaluate_contact(contact.key, {scene.tool(), X_WG}, scene.obstacles())));
    }
  }
}

TEST_CASE("at another pose a pair has the oracle's gap, normal, point and lambda") {
  SplitMix64 random(2);
  for (std::int64_t trial = 0; trial < scaled(200); ++trial) {
    const SceneParts parts = random_parts(random);
    const CheckedScene scene(parts);
    const auto set = found_contacts(scene, parts.X_WG, {0.01});
    const Pose X_WG{random_rotation(random), random_vector(random, trial % 2 == 0 ? 0.1 : 100.0)};
    const double tolerance = kRoundingTolerance * scene.extent(X_WG);
    const OracleResult all = exhaustive_contacts(
        scene.tool_spheres(), X_WG, scene.oracle_obstacles(), std::numeric_limits<double>::max());
    long double smallest = std::numeric_limits<long double>::infinity();
    for (const Contact& contact : set->contacts) {
      const OracleContact& truth = pair_of(all, contact.key);
      smallest = std::min(smallest, truth.gap);
      const Contact now = evaluate_contact(contact.key, {scene.tool(), X_WG}, scene.obstacles());
      CHECK(now.key == contact.key);
      const auto i = static_cast<std::size_t>(contact.key.tool_sphere);
      check_contact(now, truth, scene.tool_spheres()[i], X_WG, scene.obstacles(), tolerance);
    }
    const double minimum = minimum_gap_of(*set, {scene.tool(), X_WG}, scene.obstacles());
    if (set->contacts.empty()) {
      CHECK(std::isinf(minimum));
    } else {
      CHECK(std::abs(minimum - static_cast<double>(smallest)) <= tolerance);
    }
  }
}

TEST_CASE("a set evaluated at another pose has the oracle's gaps, normals, points and minimum") {
  SplitMix64 random(3);
  for (std::int64_t trial = 0; trial < scaled(200); ++trial) {
    const SceneParts parts = random_parts(random);
    const CheckedScene scene(parts);
    const auto set = found_contacts(scene, parts.X_WG, {0.01});
    const std::vector<Contact> before(set->contacts.begin(), set->contacts.end());
    const Pose X_WG{random_rotation(random), random_vector(random, 0.1)};
    const double tolerance = kRoundingTolerance * scene.extent(X_WG);
    evaluate_contacts({scene.tool(), X_WG}, scene.obstacles(), *set);
    REQUIRE(set->contacts.size() == before.size());
    const OracleResult all = exhaustive_contacts(
        scene.tool_spheres(), X_WG, scene.oracle_obstacles(), std::numeric_limits<double>::max());
    long double smallest = std::numeric_limits<long double>::infinity();
    for (std::size_t k = 0; k < before.size(); ++k) {
      const Contact& now = set->contacts[k];
      CHECK(now.key == before[k].key);
      const OracleContact& truth = pair_of(all, before[k].key);
      smallest = std::min(smallest, truth.gap);
      const auto i = static_cast<std::size_t>(now.key.tool_sphere);
      check_contact(now, truth, scene.tool_spheres()[i], X_WG, scene.obstacles(), tolerance);
    }
    if (before.empty()) {
      CHECK(std::isinf(set->minimum_gap));
    } else {
      CHECK(std::abs(set->minimum_gap - static_cast<double>(smallest)) <= tolerance);
    }
  }
}

TEST_CASE("one pair below a gap is found among those that are asked for, and only among them") {
  SplitMix64 random(4);
  std::int64_t found = 0;
  std::int64_t none = 0;
  for (std::int64_t trial = 0; trial < scaled(2'000); ++trial) {
    const SceneParts parts = random_parts(random);
    const CheckedScene scene(parts);
    const auto set = found_contacts(scene, parts.X_WG, {0.01});
    const Pose X_WG{random_rotation(random), random_vector(random, 0.1)};
    const OracleResult all = exhaustive_contacts(
        scene.tool_spheres(), X_WG, scene.oracle_obstacles(), std::numeric_limits<double>::max());
    std::vector<std::int32_t> which;
    long double smallest = std::numeric_limits<long double>::infinity();
    for (std::size_t k = 0; k < set->contacts.size(); ++k) {
      if (random.chance(0.5)) continue;
      which.push_back(static_cast<std::int32_t>(k));
      smallest = std::min(smallest, pair_of(all, set->contacts[k].key).gap);
    }
    const double least = random.uniform(-0.05, 0.1);
    if (std::abs(least - smallest) < 1e-9L) continue;
    const bool below = any_gap_below(least, {*set, which}, {scene.tool(), X_WG}, scene.obstacles());
    REQUIRE(below == (smallest < least));
    ++(below ? found : none);
  }
  CHECK(found > 0);
  CHECK(none > 0);
}

TEST_CASE("without contacts the smallest gap of the pairs is infinite") {
  CheckedScene scene;
  scene.set_tool({{{0, 0, 0}, 1e-3}});
  scene.capsules = {{{5, 0, 0}, {6, 0, 0}, 1e-3}};
  const auto set = found_contacts(scene, {}, {});
  CHECK(set->contacts.empty());
  CHECK(minimum_gap_of(*set, {scene.tool(), {}}, scene.obstacles()) ==
        std::numeric_limits<double>::infinity());
}

TEST_CASE("a capsule is round about its axis but at its ends, a body on all sides") {
  CheckedScene scene;
  scene.set_tool({{{0, 0, 0}, 1e-3}});
  scene.capsules = {{{0, 0, 0}, {0, 2, 0}, 4e-3}};
  scene.add_body({{{0, 0, 0}, 7e-3}}, {{1, 0, 0, 0}, {9e-3, 1, 0}});
  const auto touched = [&](const ContactKey& key, const Vector3& p_WC) {
    const Pose X_WG{{1, 0, 0, 0}, p_WC};
    const ToolView tool{scene.tool(), X_WG};
    return round_obstacle(evaluate_contact(key, tool, scene.obstacles()), tool, scene.obstacles());
  };
  const ContactKey capsule{ObstacleKind::kCapsule};
  CHECK(touched(capsule, {0, 1, 5e-3}).r == 4e-3);
  CHECK(touched(capsule, {0, 1, 5e-3}).axis_W == Vector3(0, 1, 0));
  CHECK(touched(capsule, {0, 2.005, 0}).axis_W == Vector3(0, 0, 0));
  CHECK(touched({ObstacleKind::kBody}, {0, 1, 0}).r == 7e-3);
  CHECK(touched({ObstacleKind::kBody}, {0, 1, 0}).axis_W == Vector3(0, 0, 0));
}

TEST_CASE("only keys of what is there name an obstacle") {
  CheckedScene scene;
  scene.capsules = {{{5, 0, 0}, {6, 0, 0}, 1e-3}, {{7, 0, 0}, {8, 0, 0}, 1e-3}};
  scene.add_body({{{0, 0, 0}, 0.01}}, {});
  const auto named = [&](ObstacleKind kind, std::int32_t obstacle, TreeSphereId sphere) {
    return has_obstacle({kind, obstacle, 0, sphere}, scene.obstacles());
  };
  CHECK(named(ObstacleKind::kCapsule, 1, 0));
  CHECK(named(ObstacleKind::kCapsule, 0, 1));
  CHECK_FALSE(named(ObstacleKind::kCapsule, 2, 0));
  CHECK_FALSE(named(ObstacleKind::kCapsule, -1, 0));
  CHECK_FALSE(named(ObstacleKind::kCapsule, 0, 2));
  CHECK_FALSE(named(ObstacleKind::kCapsule, 0, -1));
  CHECK(named(ObstacleKind::kBody, 0, 0));
  CHECK_FALSE(named(ObstacleKind::kBody, 1, 0));
  CHECK_FALSE(named(ObstacleKind::kBody, -1, 0));
  CHECK_FALSE(named(ObstacleKind::kBody, 0, 1));
}

TEST_CASE("the smallest gap is found whichever order bodies and strings come in") {
  // Pairs of two bodies and a string in turns: what is kept from one pair must not serve the next.
  SplitMix64 random(3);
  CheckedScene scene;
  scene.set_tool(random_cluster(random, 8, 0.02, 1e-3, 4e-3));
  scene.capsules = {{{-1, 0.01, 0}, {1, 0.01, 0}, 1e-3}};
  scene.add_body({{{0, 0, 0}, 0.01}}, {random_rotation(random), {0.03, 0, 0}});
  scene.add_body({{{0, 0, 0}, 0.01}}, {random_rotation(random), {-0.02, 0.03, 0}});
  for (std::int64_t trial = 0; trial < scaled(1'000); ++trial) {
    auto set = found_contacts(scene, {random_rotation(random), Vector3::Zero()}, {1.0});
    for (std::size_t i = set->contacts.size(); i > 1; --i)
      std::swap(set->contacts[i - 1], set->contacts[random.below(i)]);
    const Pose X_WG{random_rotation(random), random_vector(random, 0.05)};
    const long double truth =
        exhaustive_minimum_gap(scene.tool_spheres(), X_WG, scene.oracle_obstacles());
    const double found = minimum_gap_of(*set, {scene.tool(), X_WG}, scene.obstacles());
    REQUIRE(std::abs(found - static_cast<double>(truth)) <= 1e-14);
  }
}

}  // namespace hapticd::test
