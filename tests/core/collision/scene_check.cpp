// See scene_check.h.
#include "tests/core/collision/scene_check.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <memory>
#include <tuple>

namespace hapticd::test {
namespace {

auto order(const ContactKey& k) {
  return std::tuple{k.kind, k.obstacle, k.tool_sphere, k.obstacle_sphere};
}

/// Compares one contact with the oracle's pair.
void check_contact(const Contact& contact, const OracleContact& truth, double r_tool,
                   double tolerance) {
  CHECK(std::abs(contact.gap - static_cast<double>(truth.gap)) <= tolerance);
  CHECK(contact.nhat_OG_W.norm() == doctest::Approx(1.0).epsilon(1e-14));
  const auto offset = truth.offset_W;
  const Vector3 offset_W{static_cast<double>(offset[0]), static_cast<double>(offset[1]),
                         static_cast<double>(offset[2])};
  const auto distance = static_cast<double>(truth.distance);
  CHECK((contact.nhat_OG_W * distance - offset_W).norm() <= 4.0 * tolerance);
  static_cast<void>(r_tool);
}

}  // namespace

void CheckedScene::set_tool(std::vector<Sphere> spheres_G) {
  tool_spheres_ = std::move(spheres_G);
  tool_tree_ = build_sphere_tree(tool_spheres_);
}

void CheckedScene::add_body(std::vector<Sphere> spheres_B, const Pose& X_WB) {
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

void check_against_oracle(const CheckedScene& scene, const Pose& X_WG,
                          const QueryOptions& options) {
  const double tolerance = kRoundingTolerance * scene.extent(X_WG);
  const auto set = std::make_unique<ContactSet>();
  find_contacts(scene.tool(), X_WG, scene.obstacles(), options, *set);
  OracleResult truth = exhaustive_contacts(scene.tool_spheres(), X_WG, scene.oracle_obstacles(),
                                           static_cast<long double>(options.margin) + tolerance);
  CHECK(set->covered_margin == options.margin);
  const long double minimum = std::min<long double>(truth.minimum_gap, options.horizon);
  if (std::isinf(minimum)) {
    CHECK(std::isinf(set->minimum_gap));
  } else {
    CHECK(std::abs(set->minimum_gap - static_cast<double>(minimum)) <= tolerance);
  }

  std::vector<Contact> found(set->contacts.begin(), set->contacts.end());
  std::sort(found.begin(), found.end(),
            [](const Contact& a, const Contact& b) { return order(a.key) < order(b.key); });
  std::sort(
      truth.contacts.begin(), truth.contacts.end(),
      [](const OracleContact& a, const OracleContact& b) { return order(a.key) < order(b.key); });
  auto next = found.begin();
  for (const OracleContact& pair : truth.contacts) {
    const bool is_found = next != found.end() && next->key == pair.key;
    if (!is_found) {
      CHECK(pair.gap >= options.margin - tolerance);
      continue;
    }
    const auto i = static_cast<std::size_t>(pair.key.tool_sphere);
    check_contact(*next, pair, scene.tool_spheres()[i].r, tolerance);
    ++next;
  }
  CHECK(next == found.end());
}

}  // namespace hapticd::test
