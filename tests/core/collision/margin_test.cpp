// What a query returns and what it leaves out: the edge of the margin, the horizon, nothing to
// touch, a result used before. Gaps here are exact in binary, so that edges can be met to the bit.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "tests/core/collision/scene_check.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/no_heap.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A tool sphere of radius 1/4 at the origin; a string and a body sphere that leave a gap of
/// exactly 1/2 each.
CheckedScene exact_scene(bool string, bool body) {
  CheckedScene scene;
  scene.set_tool({{{0, 0, 0}, 0.25}});
  if (string) scene.capsules = {{{-4, 1, 0}, {4, 1, 0}, 0.25}};
  if (body) scene.add_body({{{0, 0, 2}, 1.0}}, {{1, 0, 0, 0}, {0, 0, -0.25}});
  return scene;
}

}  // namespace

TEST_CASE("a gap equal to the margin is left out, one below it by the last bit is returned") {
  for (const bool string : {true, false}) {
    const CheckedScene scene = exact_scene(string, !string);
    const auto at = found_contacts(scene, {}, {0.5});
    CHECK(at->contacts.empty());
    CHECK(at->minimum_gap == 0.5);
    CHECK(at->covered_margin == 0.5);
    const auto above = found_contacts(scene, {}, {std::nextafter(0.5, 1.0)});
    REQUIRE(above->contacts.size() == 1);
    CHECK(above->contacts[0].gap == 0.5);
    const auto below = found_contacts(scene, {}, {std::nextafter(0.5, 0.0)});
    CHECK(below->contacts.empty());
  }
}

TEST_CASE("a gap beyond the horizon is reported as the horizon, one within it truly") {
  const CheckedScene scene = exact_scene(true, true);
  CHECK(found_contacts(scene, {}, {0.25, 0.25})->minimum_gap == 0.25);
  CHECK(found_contacts(scene, {}, {0.25, 0.375})->minimum_gap == 0.375);
  CHECK(found_contacts(scene, {}, {0.25, 0.5})->minimum_gap == 0.5);
  CHECK(found_contacts(scene, {}, {0.25, 0.75})->minimum_gap == 0.5);
  CHECK(found_contacts(scene, {}, {0.25, kInfinity})->minimum_gap == 0.5);
  CHECK(found_contacts(scene, {}, {0.625, 0.625})->minimum_gap == 0.5);
}

TEST_CASE("random scenes keep the oracle's minimum gap up to any horizon") {
  SplitMix64 random(1);
  for (std::int64_t trial = 0; trial < scaled(2'000); ++trial) {
    const SceneParts parts = random_parts(random);
    const CheckedScene scene(parts);
    QueryOptions options;
    options.margin = std::pow(10.0, random.uniform(-9.0, -2.0));
    options.horizon = options.margin * (1.0 + random.uniform(0.0, 20.0));
    // Often far off, so that there is nothing below the margin.
    const Pose X_WG{random_rotation(random), random_vector(random, trial % 2 == 0 ? 0.1 : 2.0)};
    check_against_oracle(scene, X_WG, options);
  }
}

TEST_CASE("without obstacles there is no contact, and the gap is the horizon") {
  CheckedScene scene;
  scene.set_tool(hand_spheres());
  const auto endless = found_contacts(scene, {}, {});
  CHECK(endless->contacts.empty());
  CHECK(endless->minimum_gap == kInfinity);
  CHECK(endless->covered_margin == QueryOptions{}.margin);
  CHECK(found_contacts(scene, {}, {1e-3, 0.5})->minimum_gap == 0.5);
}

TEST_CASE("a margin wider than the scene returns every pair") {
  SplitMix64 random(2);
  for (const double margin : {10.0, 1e9, 1e300}) {
    CheckedScene scene;
    scene.set_tool(random_cluster(random, 20, 0.1, 0.0, 0.01));
    scene.capsules = seven_strings();
    scene.add_body(random_cluster(random, 30, 0.1, 0.0, 0.01),
                   {random_rotation(random), Vector3::Zero()});
    scene.add_body(random_cluster(random, 9, 0.1, 0.0, 0.01),
                   {random_rotation(random), Vector3::Zero()});
    const auto set = found_contacts(scene, {random_rotation(random), Vector3::Zero()}, {margin});
    CHECK(set->contacts.size() == 20 * (7 + 30 + 9));
  }
}

TEST_CASE("the smallest margin returns exactly the pairs that touch") {
  SplitMix64 random(3);
  std::size_t touching = 0;
  for (std::int64_t trial = 0; trial < scaled(500) + 45; ++trial) {
    const SceneParts parts = random_parts(random);
    const CheckedScene scene(parts);
    QueryOptions options;
    options.margin = std::numeric_limits<double>::denorm_min();
    const auto set = found_contacts(scene, parts.X_WG, options);
    for (const Contact& contact : set->contacts) CHECK(contact.gap <= 0.0);
    touching += set->contacts.size();
    check_against_oracle(scene, parts.X_WG, options);
  }
  CHECK(touching > 20);
}

TEST_CASE("a result used before does not shine through") {
  SplitMix64 random(4);
  auto used = std::make_unique<ContactSet>();
  for (std::int64_t trial = 0; trial < scaled(500); ++trial) {
    const SceneParts parts = random_parts(random);
    const CheckedScene scene(parts);
    const Pose X_WG{random_rotation(random), random_vector(random, trial % 3 == 0 ? 2.0 : 0.1)};
    const QueryOptions options{random.uniform(1e-4, 1e-2)};
    const auto fresh = found_contacts(scene, X_WG, options);
    find_contacts({scene.tool(), X_WG}, scene.obstacles(), options, *used);
    REQUIRE(used->contacts.size() == fresh->contacts.size());
    CHECK(used->covered_margin == fresh->covered_margin);
    CHECK(used->minimum_gap == fresh->minimum_gap);
    CHECK(used->tests == fresh->tests);
    for (std::size_t i = 0; i < fresh->contacts.size(); ++i)
      CHECK(same_bits(used->contacts[i], fresh->contacts[i]));
  }
}

TEST_CASE("queries near, far, full and coarse leave the heap alone") {
  SplitMix64 random(5);
  const SceneParts parts = random_parts(random);
  const CheckedScene scene(parts);
  const SphereTreeView tool = scene.tool();
  const ObstaclesView obstacles = scene.obstacles();
  auto set = std::make_unique<ContactSet>();
  std::size_t most = 0;
  double checksum = 0.0;
  const NoHeapScope scope;
  for (int i = 0; i < 300; ++i) {
    const Pose X_WG{random_rotation(random), random_vector(random, i % 2 == 0 ? 0.05 : 3.0)};
    QueryOptions options;
    if (i % 3 == 0) options.margin = 1.0;
    if (i % 5 == 0) options.tool_level = options.body_level = 1;
    find_contacts({tool, X_WG}, obstacles, options, *set);
    most = std::max(most, set->contacts.size());
    const double gap = minimum_gap_of(*set, {tool, X_WG}, obstacles);
    if (std::isfinite(gap)) checksum += gap;
    if (!set->contacts.empty())
      checksum += evaluate_contact(set->contacts[0].key, {tool, X_WG}, obstacles).gap;
  }
  const std::int64_t touched = scope.count();
  CHECK(touched == 0);
  CHECK(most == kMaxCandidates);
  CHECK(std::isfinite(checksum));
}

}  // namespace hapticd::test
