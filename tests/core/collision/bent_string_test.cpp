// Bent strings and groups of capsules: what the query finds against exhaustive search over the legs
// as separate capsules, and the same with and without groups.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/core/collision/scene_check.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// A segment that the oracle sees as a capsule, and what the product calls it.
struct NamedSegment {
  std::int32_t capsule;
  std::int32_t leg;
  double lambda_from;
  double lambda_to;
};

struct BentScene {
  std::vector<Sphere> tool_G;
  SphereTree tree;
  std::vector<Capsule> capsules_W;
  std::vector<StringBend> bends;
  std::vector<CapsuleGroup> groups;
  std::vector<Capsule> segments_W;
  std::vector<NamedSegment> names;
  Pose X_WG;

  [[nodiscard]] ObstaclesView obstacles() const {
    return {capsules_W, {}, bends, groups, box_of(groups)};
  }
};

BentScene random_scene(SplitMix64& random) {
  BentScene scene;
  scene.tool_G = random_cluster(random, 1 + static_cast<int>(random.below(60)), 0.05, 1e-4, 0.02);
  scene.tree = build_sphere_tree(scene.tool_G);
  scene.X_WG = {random_rotation(random), random_vector(random, 0.1)};
  const auto count = static_cast<std::int32_t>(1 + random.below(60));
  for (std::int32_t i = 0; i < count; ++i) {
    const Capsule capsule{random_vector(random, 0.5), random_vector(random, 0.5),
                          random.uniform(0.0, 0.01)};
    scene.capsules_W.push_back(capsule);
    if (random.chance(0.8)) {
      scene.segments_W.push_back(capsule);
      scene.names.push_back({i, 0, 0.0, 1.0});
      continue;
    }
    const double lambda = random.chance(0.2) ? std::round(random.uniform()) : random.uniform();
    const StringBend bend{i, lambda, random_vector(random, 0.05)};
    scene.bends.push_back(bend);
    const Vector3 p_P = capsule.p_A + lambda * (capsule.p_B - capsule.p_A) + bend.u_W;
    scene.segments_W.push_back({capsule.p_A, p_P, capsule.r});
    scene.names.push_back({i, 0, 0.0, lambda});
    scene.segments_W.push_back({p_P, capsule.p_B, capsule.r});
    scene.names.push_back({i, 1, lambda, 1.0});
  }
  for (std::size_t i = 0; kCapsulesPerGroup * i < scene.capsules_W.size(); ++i) {
    scene.groups.push_back(group_capsules(scene.capsules_W, i));
  }
  return scene;
}

}  // namespace

TEST_CASE("a bent string is found as its two legs, with the position along the whole string") {
  SplitMix64 random(71);
  std::int64_t bent_contacts = 0;
  for (std::int64_t trial = 0; trial < scaled(20'000); ++trial) {
    const BentScene scene = random_scene(random);
    QueryOptions options;
    options.margin = random.uniform(1e-3, 0.03);
    ContactSet set;
    find_contacts({scene.tree.view(), scene.X_WG}, scene.obstacles(), options, set);
    OracleResult truth = exhaustive_contacts(scene.tool_G, scene.X_WG, {scene.segments_W, {}},
                                             static_cast<long double>(options.margin) + 1e-12L);
    // The oracle's names become the product's.
    for (OracleContact& contact : truth.contacts) {
      const NamedSegment& name = scene.names[static_cast<std::size_t>(contact.key.obstacle)];
      contact.key.obstacle = name.capsule;
      contact.key.obstacle_sphere = name.leg;
      contact.lambda = name.lambda_from + contact.lambda * (name.lambda_to - name.lambda_from);
    }
    check_set(set, truth, options, 1e-13);
    for (const Contact& found : set.contacts) {
      const auto same = [&](const OracleContact& c) { return c.key == found.key; };
      const auto at = std::find_if(truth.contacts.begin(), truth.contacts.end(), same);
      REQUIRE(at != truth.contacts.end());
      REQUIRE(std::abs(static_cast<double>(at->lambda) - found.lambda) < 1e-9);
      const Contact again =
          evaluate_contact(found.key, {scene.tree.view(), scene.X_WG}, scene.obstacles());
      REQUIRE(same_bits(again, found));
      if (scene.names.size() > scene.capsules_W.size() && found.key.obstacle_sphere == 1) {
        ++bent_contacts;
      }
    }
  }
  CHECK(bent_contacts > scaled(20'000) / 10);
}

TEST_CASE(
    "groups of capsules change no bit of what is found, near or far, and spare the far ones") {
  SplitMix64 random(72);
  for (std::int64_t trial = 0; trial < scaled(10'000); ++trial) {
    BentScene scene = random_scene(random);
    if (random.chance(0.5)) scene.bends.clear();
    ObstaclesView plain = scene.obstacles();
    plain.groups = {};
    QueryOptions options;
    options.margin = random.uniform(1e-3, 0.03);
    if (random.chance(0.5)) options.horizon = options.margin + random.uniform(0.0, 0.3);
    const Pose X_WG{scene.X_WG.q, scene.X_WG.p * random.uniform(0.0, 10.0)};
    ContactSet with;
    ContactSet without;
    find_contacts({scene.tree.view(), X_WG}, scene.obstacles(), options, with);
    find_contacts({scene.tree.view(), X_WG}, plain, options, without);
    REQUIRE(with.minimum_gap == without.minimum_gap);
    REQUIRE(with.contacts.size() == without.contacts.size());
    REQUIRE(with.tests == without.tests);
    for (std::size_t k = 0; k < with.contacts.size(); ++k) {
      REQUIRE(same_bits(with.contacts[k], without.contacts[k]));
    }
  }
}

TEST_CASE("a look at a box axis by axis says what its squared distance says, to the last bit") {
  SplitMix64 random(73);
  int near_ones = 0;
  for (std::int64_t trial = 0; trial < scaled(200'000); ++trial) {
    const Capsule capsule{random_vector(random, 1.0), random_vector(random, 1.0),
                          random.uniform(0.0, 0.1)};
    const CapsuleGroup box = box_of(capsule);
    const Vector3 p = random_vector(random, 2.0);
    double squared = 0.0;
    for (Eigen::Index k = 0; k < 3; ++k) {
      const double outside = std::max({box.lower[k] - p[k], p[k] - box.upper[k], 0.0});
      squared += outside * outside;
    }
    // Often as near as makes no difference: the distance rounded, or the next number.
    double radius = random.chance(0.5) ? std::sqrt(squared) : random.uniform(0.0, 2.0);
    if (random.chance(0.3)) radius = std::nextafter(radius, random.chance(0.5) ? 0.0 : 9.0);
    const bool touches = !(squared > radius * radius);
    near_ones += touches ? 1 : 0;
    REQUIRE(may_touch(box, {p, radius}) == touches);
    REQUIRE(capsule_may_touch(capsule, {p, radius}) == touches);
  }
  CHECK(near_ones > scaled(20'000));
  CHECK(near_ones < scaled(180'000));
}

TEST_CASE("a string's share of its vertex's deflection falls evenly to nothing at both ends") {
  for (const double vertex : {0.0, 1e-6, 0.25, 0.5, 1.0}) {
    CAPTURE(vertex);
    const StringBend bend{0, vertex, Vector3::Zero()};
    // An end stays where it is, also with the vertex there.
    CHECK(deflection_share(bend, 0.0) == 0.0);
    CHECK(deflection_share(bend, 1.0) == 0.0);
    if (vertex > 0.0 && vertex < 1.0) CHECK(deflection_share(bend, vertex) == 1.0);
    if (vertex > 0.0) CHECK(deflection_share(bend, 0.5 * vertex) == doctest::Approx(0.5));
    if (vertex < 1.0) {
      CHECK(deflection_share(bend, 0.5 * (1.0 + vertex)) == doctest::Approx(0.5));
    }
  }
}

}  // namespace hapticd::test
