// Queries of a tool whose parts stand aside. Truth: exhaustive search with the spheres of the parts
// where they stand.
#include <doctest/doctest.h>

#include <cmath>

#include <algorithm>
#include <limits>
#include <memory>
#include <tuple>
#include <vector>

#include "core/collision/query.h"
#include "core/tree/sphere_tree.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/scale.h"
#include "tests/truth/contact_oracle.h"

namespace hapticd::test {
namespace {

/// A tool in parts, two of which are displaced, near some capsules and a body.
struct PartedScene {
  std::vector<Sphere> tool_G;
  std::vector<Sphere> displaced_G;
  std::vector<std::uint8_t> part_of_sphere;
  std::vector<PartDisplacement> parts;
  SphereTree tree;
  std::vector<Capsule> capsules_W;
  std::vector<Sphere> body_B;
  SphereTree body;
  std::vector<BodyView> bodies;
  Pose X_WG;

  explicit PartedScene(SplitMix64& random) {
    tool_G = random_cluster(random, 1 + static_cast<int>(random.below(80)), 0.05, 1e-4, 0.01);
    tree = build_sphere_tree(tool_G);
    const double far = random.chance(0.3) ? 0.3 : 0.02;
    for (const std::int32_t part : {3, 1}) {
      parts.push_back({part, random_vector(random, far)});
    }
    displaced_G = tool_G;
    for (Sphere& sphere : displaced_G) {
      part_of_sphere.push_back(static_cast<std::uint8_t>(random.below(5)));
      for (const PartDisplacement& part : parts) {
        if (part.part == part_of_sphere.back()) sphere.p += part.v_G;
      }
    }
    X_WG = {random_rotation(random), random_vector(random, 0.1)};
    for (int i = 0; i < 5; ++i) {
      capsules_W.push_back({random_vector(random, 0.5), random_vector(random, 0.5), 1e-3});
    }
    body_B = random_cluster(random, 40, 0.1, 1e-3, 0.02);
    body = build_sphere_tree(body_B);
    bodies.push_back({body.view(), {random_rotation(random), random_vector(random, 0.2)}});
  }

  [[nodiscard]] DisplacedParts displaced() const { return {part_of_sphere, parts}; }
  [[nodiscard]] ObstaclesView obstacles() const { return {capsules_W, bodies}; }
  [[nodiscard]] OracleResult truth(double margin) const {
    const OracleBody oracle_body{body_B, bodies.front().X_WB};
    return exhaustive_contacts(displaced_G, X_WG, {capsules_W, {&oracle_body, 1}}, margin);
  }
};

auto order_of(const ContactKey& key) {
  return std::tuple{key.kind, key.obstacle, key.tool_sphere, key.obstacle_sphere};
}

}  // namespace

TEST_CASE("parts that stand aside are found where they stand, and nowhere else") {
  SplitMix64 random(91);
  const auto set = std::make_unique<ContactSet>();
  for (std::int64_t trial = 0; trial < scaled(20'000); ++trial) {
    const PartedScene scene(random);
    const double margin = random.uniform(1e-3, 0.03);
    find_contacts({scene.tree.view(), scene.X_WG, scene.displaced()}, scene.obstacles(),
                  {.margin = margin, .horizon = 10.0}, *set);
    OracleResult truth = scene.truth(margin);
    REQUIRE(set->covered_margin == margin);
    REQUIRE(set->contacts.size() == truth.contacts.size());
    std::sort(set->contacts.begin(), set->contacts.end(),
              [](const Contact& a, const Contact& b) { return order_of(a.key) < order_of(b.key); });
    std::sort(truth.contacts.begin(), truth.contacts.end(),
              [](const OracleContact& a, const OracleContact& b) {
                return order_of(a.key) < order_of(b.key);
              });
    for (std::size_t i = 0; i < truth.contacts.size(); ++i) {
      const Contact& contact = set->contacts[i];
      const OracleContact& oracle = truth.contacts[i];
      REQUIRE(contact.key == oracle.key);
      REQUIRE(std::abs(contact.gap - static_cast<double>(oracle.gap)) < 1e-14);
      // The point lies on the sphere where the part stands.
      const Sphere& sphere = scene.displaced_G[static_cast<std::size_t>(contact.key.tool_sphere)];
      const Vector3 p_WC = transform(scene.X_WG, sphere.p) - sphere.r * contact.nhat_OG_W;
      REQUIRE((contact.p_WC - p_WC).norm() < 1e-14);
    }
    // Beyond the margin the smallest gap is a lower bound, no farther off than the parts are aside.
    const auto smallest = static_cast<double>(truth.minimum_gap);
    REQUIRE(set->minimum_gap <= smallest + 1e-13);
    if (smallest < margin) {
      REQUIRE(set->minimum_gap >= smallest - 1e-13);
    } else {
      REQUIRE(set->minimum_gap >= std::max(margin, smallest - 2.0 * scene.displaced().greatest()));
    }
  }
}

TEST_CASE("a pair evaluated anew is where its part stands, alone or among others") {
  SplitMix64 random(92);
  const auto set = std::make_unique<ContactSet>();
  for (std::int64_t trial = 0; trial < scaled(5'000); ++trial) {
    const PartedScene scene(random);
    find_contacts({scene.tree.view(), scene.X_WG, scene.displaced()}, scene.obstacles(),
                  {.margin = 0.02, .horizon = 0.02}, *set);
    const auto found = std::make_unique<ContactSet>(*set);
    evaluate_contacts({scene.tree.view(), scene.X_WG, scene.displaced()}, scene.obstacles(), *set);
    double smallest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < set->contacts.size(); ++i) {
      const Contact& contact = set->contacts[i];
      const Contact alone = evaluate_contact(
          contact.key, {scene.tree.view(), scene.X_WG, scene.displaced()}, scene.obstacles());
      REQUIRE(contact.gap == alone.gap);
      REQUIRE(std::abs(contact.gap - found->contacts[i].gap) < 1e-14);
      REQUIRE((contact.nhat_OG_W - found->contacts[i].nhat_OG_W).norm() < 1e-9);
      smallest = std::min(smallest, contact.gap);
    }
    REQUIRE(set->minimum_gap == smallest);
    REQUIRE(minimum_gap_of(*set, {scene.tree.view(), scene.X_WG, scene.displaced()},
                           scene.obstacles()) == smallest);
  }
}

}  // namespace hapticd::test
