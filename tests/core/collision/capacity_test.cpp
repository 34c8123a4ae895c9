// More pairs below the margin than a result holds: it keeps the nearest, says how far its
// knowledge reaches, and does not depend on the order in which the pairs were met.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/core/collision/scene_check.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

/// Checks a full `set` against all pairs, which are ordered by gap.
void check_full(const ContactSet& set, const std::vector<OracleContact>& all, double tolerance) {
  constexpr auto kKept = static_cast<std::size_t>(kMaxCandidates);
  REQUIRE(all.size() > kKept);
  REQUIRE(set.contacts.size() == kKept);
  CHECK(std::abs(set.minimum_gap - static_cast<double>(all.front().gap)) <= tolerance);
  // The nearest omitted pair is the first that did not fit.
  CHECK(std::abs(set.covered_margin - static_cast<double>(all[kKept].gap)) <= tolerance);
  const std::vector<Contact> found = by_key(set);
  const auto has = [&](const ContactKey& key) {
    const auto at =
        std::lower_bound(found.begin(), found.end(), key,
                         [](const Contact& c, const ContactKey& k) { return key_less(c.key, k); });
    return at != found.end() && at->key == key;
  };
  bool all_covered = true;
  for (const OracleContact& pair : all) {
    if (pair.gap < set.covered_margin - tolerance) all_covered = all_covered && has(pair.key);
  }
  CHECK(all_covered);
  for (const Contact& contact : found) REQUIRE(contact.gap <= set.covered_margin);
  for (std::size_t i = 1; i < found.size(); ++i) REQUIRE(!(found[i - 1].key == found[i].key));
}

SceneParts crowded_parts(SplitMix64& random) {
  SceneParts parts = random_parts(random);
  parts.tool_G = random_cluster(random, 80, 0.05, 1e-3, 8e-3);
  parts.bodies.push_back({random_cluster(random, 150, 0.05, 1e-3, 0.01), {}});
  return parts;
}

}  // namespace

TEST_CASE("a full result keeps the nearest pairs and covers up to the nearest omitted") {
  SplitMix64 random(1);
  for (std::int64_t trial = 0; trial < scaled(200); ++trial) {
    const SceneParts parts = crowded_parts(random);
    const CheckedScene scene(parts);
    QueryOptions options;
    options.margin = trial % 2 == 0 ? 0.2 : 1e6;
    const OracleResult truth = exhaustive_contacts(scene.tool_spheres(), parts.X_WG,
                                                   scene.oracle_obstacles(), options.margin);
    const auto set = found_contacts(scene, parts.X_WG, options);
    CHECK(set->covered_margin < options.margin);
    check_full(*set, truth.contacts, kRoundingTolerance * scene.extent(parts.X_WG));
  }
}

TEST_CASE("a result that is full of deep penetrations covers a negative margin") {
  SplitMix64 random(2);
  for (std::int64_t trial = 0; trial < scaled(50); ++trial) {
    CheckedScene scene;
    scene.set_tool(random_cluster(random, 90, 0.01, 0.01, 0.05));
    scene.capsules = {{{-1, 0, 0}, {1, 0, 0}, 0.05}, {{0, -1, 0}, {0, 1, 0}, 0.1}};
    scene.add_body(random_cluster(random, 90, 0.01, 0.05, 0.2),
                   {random_rotation(random), Vector3::Zero()});
    scene.add_body(random_cluster(random, 40, 0.02, 0.05, 0.2),
                   {random_rotation(random), Vector3::Zero()});
    const Pose X_WG{random_rotation(random), random_vector(random, 0.01)};
    const OracleResult truth =
        exhaustive_contacts(scene.tool_spheres(), X_WG, scene.oracle_obstacles(), 1.0L);
    const auto set = found_contacts(scene, X_WG, {});
    CHECK(set->covered_margin < -0.01);
    check_full(*set, truth.contacts, kRoundingTolerance * scene.extent(X_WG));
  }
}

TEST_CASE("exactly as many pairs as fit leave the margin whole, one more shrinks it to its gap") {
  // 32 spheres in a row over 64 points, each pair with a gap of its own below 0.1 m; and one point
  // 0.499 m from the first sphere, met before the others (a string) or after them (a body).
  std::vector<Sphere> tool;
  std::vector<Sphere> body;
  tool.reserve(32);
  body.reserve(64);
  for (int i = 0; i < 32; ++i) tool.push_back({{1e-3 * i, 0.02 + 1e-5 * i * i, 0}, 1e-3});
  for (int i = 0; i < 64; ++i) body.push_back({{7.3e-4 * i, 0, 1e-5 * i * i}, 0.0});
  const Vector3 lone(-0.5, 0.02, 0);
  for (const bool first : {true, false}) {
    CheckedScene scene;
    scene.set_tool(tool);
    scene.add_body(body, {});
    if (first) scene.capsules = {{lone, lone, 0.0}};
    if (!first) scene.add_body({{lone, 0.0}}, {});
    const auto fits = found_contacts(scene, {}, {0.4985});
    CHECK(fits->contacts.size() == kMaxCandidates);
    CHECK(fits->covered_margin == 0.4985);
    const auto full = found_contacts(scene, {}, {0.4995});
    CHECK(full->contacts.size() == kMaxCandidates);
    CHECK(full->covered_margin == within(0.499, 1e-12));
    for (const Contact& contact : full->contacts) CHECK(contact.gap < 0.1);
  }
}

TEST_CASE("coincident pairs that do not all fit leave a result that is the same every time") {
  std::vector<Sphere> tool(60, Sphere{{0, 0, 0}, 0.25});
  std::vector<Sphere> body(60, Sphere{{0, 0, 0}, 0.25});
  CheckedScene scene;
  scene.set_tool(tool);
  scene.add_body(body, {{1, 0, 0, 0}, {0.625, 0, 0}});
  const auto a = found_contacts(scene, {}, {0.5});
  const auto b = found_contacts(scene, {}, {0.5});
  REQUIRE(a->contacts.size() == kMaxCandidates);
  CHECK(a->covered_margin == 0.125);
  CHECK(a->minimum_gap == 0.125);
  bool same = true;
  for (std::size_t i = 0; i < a->contacts.size(); ++i)
    same = same && same_bits(a->contacts[i], b->contacts[i]);
  CHECK(same);
  // Of equal gaps the smallest keys stay.
  const std::vector<Contact> found = by_key(*a);
  for (std::size_t i = 0; i < found.size(); ++i) {
    CHECK(found[i].key.tool_sphere == static_cast<TreeSphereId>(i / 60));
    CHECK(found[i].key.obstacle_sphere == static_cast<TreeSphereId>(i % 60));
  }
}

TEST_CASE("the margin covered is the gap of equal pairs too when none of them took a place") {
  // 64 strings fill the result; the pairs of one more have the same gap and later keys.
  CheckedScene scene;
  scene.set_tool(std::vector<Sphere>(32, Sphere{{0, 0, 0}, 0.25}));
  scene.capsules.assign(65, Capsule{{-1, 0.625, 0}, {1, 0.625, 0}, 0.25});
  const auto set = found_contacts(scene, {}, {0.5});
  CHECK(set->contacts.size() == kMaxCandidates);
  CHECK(set->covered_margin == 0.125);
}

TEST_CASE("which pairs are kept does not depend on the order of strings and bodies") {
  SplitMix64 random(3);
  for (std::int64_t trial = 0; trial < scaled(100); ++trial) {
    SceneParts parts = crowded_parts(random);
    const auto a = found_contacts(CheckedScene(parts), parts.X_WG, {0.3});
    std::reverse(parts.capsules_W.begin(), parts.capsules_W.end());
    std::reverse(parts.bodies.begin(), parts.bodies.end());
    auto b = found_contacts(CheckedScene(parts), parts.X_WG, {0.3});
    for (Contact& contact : b->contacts) {
      const bool is_body = contact.key.kind == ObstacleKind::kBody;
      const std::size_t count = is_body ? parts.bodies.size() : parts.capsules_W.size();
      contact.key.obstacle = static_cast<std::int32_t>(count) - 1 - contact.key.obstacle;
    }
    CHECK(a->covered_margin == b->covered_margin);
    const std::vector<Contact> kept_a = by_key(*a);
    const std::vector<Contact> kept_b = by_key(*b);
    REQUIRE(kept_a.size() == kept_b.size());
    bool same = true;
    for (std::size_t i = 0; i < kept_a.size(); ++i) same = same && same_bits(kept_a[i], kept_b[i]);
    CHECK(same);
  }
}

}  // namespace hapticd::test
