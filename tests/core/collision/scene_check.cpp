// See scene_check.h.
#include "tests/core/collision/scene_check.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>

#include "tests/support/contact_scenes.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

auto order(const ContactKey& k) {
  return std::tuple{k.kind, k.obstacle, k.tool_sphere, k.obstacle_sphere};
}

bool same_number(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

bool same_vector(const Vector3& a, const Vector3& b) {
  return same_number(a.x(), b.x()) && same_number(a.y(), b.y()) && same_number(a.z(), b.z());
}

}  // namespace

SceneParts random_parts(SplitMix64& random) {
  SceneParts parts;
  parts.tool_G = random_cluster(random, 40 + static_cast<int>(random.below(20)), 0.08, 1e-3, 8e-3);
  for (int k = 0; k < 5; ++k) {
    // Through the tool's neighbourhood, one of them with an end there.
    const Vector3 middle = random_vector(random, 0.08);
    const Vector3 half = random_vector(random, 0.5);
    parts.capsules_W.push_back(
        {middle - half, k == 0 ? middle : Vector3(middle + half), random.uniform(0.0, 3e-3)});
  }
  for (int k = 0; k < 3; ++k) {
    const int count = 1 + static_cast<int>(random.below(200));
    parts.bodies.push_back({random_cluster(random, count, 0.15, 0.0, 0.01),
                            {random_rotation(random), random_vector(random, 0.1)}});
  }
  parts.X_WG = {random_rotation(random), random_vector(random, 0.05)};
  return parts;
}

CheckedScene::CheckedScene(const SceneParts& parts) : capsules(parts.capsules_W) {
  set_tool(parts.tool_G);
  for (const SceneParts::Body& body : parts.bodies) add_body(body.spheres_B, body.X_WB);
}

void CheckedScene::set_tool(std::vector<Sphere> spheres_G) {
  tool_spheres_ = std::move(spheres_G);
  tool_tree_ = build_sphere_tree(tool_spheres_);
}

void CheckedScene::add_body(std::vector<Sphere> spheres_B, const Pose& X_WB) {
  REQUIRE(X_WB.p.allFinite());  // Product and oracle agree on nonsense: no contact.
  body_spheres_.push_back(std::move(spheres_B));
  body_trees_.push_back(build_sphere_tree(body_spheres_.back()));
  body_views_.push_back({body_trees_.back().view(), X_WB});
  oracle_bodies_.push_back({body_spheres_.back(), X_WB});
}

double CheckedScene::extent(const Pose& X_WG) const {
  double result = X_WG.p.norm() + reach(tool());
  for (const Capsule& k : capsules) {
    result = std::max({result, k.p_A.norm() + k.r, k.p_B.norm() + k.r});
  }
  for (const BodyView& b : body_views_) result = std::max(result, b.X_WB.p.norm() + reach(b.tree));
  return result;
}

std::unique_ptr<ContactSet> found_contacts(const CheckedScene& scene, const Pose& X_WG,
                                           const QueryOptions& options) {
  auto set = std::make_unique<ContactSet>();
  find_contacts({scene.tool(), X_WG}, scene.obstacles(), options, *set);
  return set;
}

bool key_less(const ContactKey& a, const ContactKey& b) { return order(a) < order(b); }

std::vector<Contact> by_key(const ContactSet& set) {
  std::vector<Contact> contacts(set.contacts.begin(), set.contacts.end());
  std::sort(contacts.begin(), contacts.end(),
            [](const Contact& a, const Contact& b) { return key_less(a.key, b.key); });
  return contacts;
}

bool same_bits(const Contact& a, const Contact& b) {
  return a.key == b.key && same_vector(a.nhat_OG_W, b.nhat_OG_W) && same_vector(a.p_WC, b.p_WC) &&
         same_number(a.gap, b.gap) && same_number(a.lambda, b.lambda);
}

void check_contact(const Contact& found, const OracleContact& truth, const Sphere& sphere_G,
                   const Pose& X_WG, const ObstaclesView& obstacles, double tolerance) {
  CHECK(std::abs(found.gap - static_cast<double>(truth.gap)) <= tolerance);
  CHECK(found.nhat_OG_W.norm() == within(1.0, 1e-14));
  const auto offset = truth.offset_W;
  const Vector3 offset_W{static_cast<double>(offset[0]), static_cast<double>(offset[1]),
                         static_cast<double>(offset[2])};
  const auto distance = static_cast<double>(truth.distance);
  CHECK((found.nhat_OG_W * distance - offset_W).norm() <= 4.0 * tolerance);
  const Vector3 p_WC = transform(X_WG, sphere_G.p) - sphere_G.r * found.nhat_OG_W;
  CHECK((found.p_WC - p_WC).norm() <= 4.0 * tolerance);
  if (found.key.kind == ObstacleKind::kBody) {
    CHECK(found.lambda == 0.0);
    return;
  }
  const Capsule& capsule = obstacles.capsules_W[static_cast<std::size_t>(found.key.obstacle)];
  const double L = (capsule.p_B - capsule.p_A).norm();
  CHECK(std::abs(found.lambda - static_cast<double>(truth.lambda)) * L <= 4.0 * tolerance);
}

void check_set(const ContactSet& set, OracleResult truth, const QueryOptions& options,
               double tolerance) {
  CHECK(set.covered_margin == options.margin);
  const long double minimum = std::min<long double>(truth.minimum_gap, options.horizon);
  if (std::isinf(minimum)) {
    CHECK(std::isinf(set.minimum_gap));
  } else {
    CHECK(std::abs(set.minimum_gap - static_cast<double>(minimum)) <= tolerance);
  }
  const std::vector<Contact> found = by_key(set);
  std::sort(truth.contacts.begin(), truth.contacts.end(),
            [](const OracleContact& a, const OracleContact& b) { return key_less(a.key, b.key); });
  auto next = found.begin();
  for (const OracleContact& pair : truth.contacts) {
    const bool is_found = next != found.end() && next->key == pair.key;
    if (is_found) {
      CHECK(std::abs(next->gap - static_cast<double>(pair.gap)) <= tolerance);
      CHECK(next->gap < options.margin);
      ++next;
    } else {
      CHECK(pair.gap >= options.margin - tolerance);
    }
  }
  CHECK(next == found.end());
}

void check_against_oracle(const CheckedScene& scene, const Pose& X_WG,
                          const QueryOptions& options) {
  const double tolerance = kRoundingTolerance * scene.extent(X_WG);
  const auto set = found_contacts(scene, X_WG, options);
  const OracleResult truth =
      exhaustive_contacts(scene.tool_spheres(), X_WG, scene.oracle_obstacles(),
                          static_cast<long double>(options.margin) + tolerance);
  check_set(*set, truth, options, tolerance);
  for (const OracleContact& pair : truth.contacts) {
    const Contact* const found =
        std::find_if(set->contacts.begin(), set->contacts.end(),
                     [&](const Contact& contact) { return contact.key == pair.key; });
    if (found == set->contacts.end()) continue;
    const auto i = static_cast<std::size_t>(pair.key.tool_sphere);
    check_contact(*found, pair, scene.tool_spheres()[i], X_WG, scene.obstacles(), tolerance);
  }
}

}  // namespace hapticd::test
