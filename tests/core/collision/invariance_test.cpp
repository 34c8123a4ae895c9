// What must not change the contacts: the order of spheres and obstacles, a mirror, a rigid motion
// of everything, the unit of length, the other direction of a string.
#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <numeric>

#include "core/math/rotation.h"
#include "tests/core/collision/scene_check.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/pose_composition.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr double kMargin = 0.01;

/// What became of the second scene's contacts, seen from the first.
struct Change {
  double unit = 1.0;  ///< lengths of the second per length of the first
  std::function<Vector3(const Vector3&)> direction = [](const Vector3& n) { return n; };
  std::function<ContactKey(const ContactKey&)> key = [](const ContactKey& k) { return k; };
};

/// Contacts of `a` and `b` are the same physical pairs with the same numbers to `tolerance` (m, in
/// a's unit); returns their number.
std::size_t check_same(const SceneParts& a, const SceneParts& b, const Change& change,
                       double tolerance) {
  const CheckedScene scene_a(a);
  const CheckedScene scene_b(b);
  const auto set_a = found_contacts(scene_a, a.X_WG, {kMargin});
  const auto set_b = found_contacts(scene_b, b.X_WG, {kMargin * change.unit});
  for (Contact& contact : set_b->contacts) {
    contact.key = change.key(contact.key);
    contact.gap /= change.unit;
  }
  CHECK(std::abs(set_a->minimum_gap - set_b->minimum_gap / change.unit) <= tolerance);
  const std::vector<Contact> from_a = by_key(*set_a);
  const std::vector<Contact> from_b = by_key(*set_b);
  auto other = from_b.begin();
  for (const Contact& contact : from_a) {
    while (other != from_b.end() && key_less(other->key, contact.key)) {
      CHECK(other->gap >= kMargin - tolerance);
      ++other;
    }
    if (other == from_b.end() || !(other->key == contact.key)) {
      CHECK(contact.gap >= kMargin - tolerance);
      continue;
    }
    CHECK(std::abs(contact.gap - other->gap) <= tolerance);
    const Sphere& sphere = a.tool_G[static_cast<std::size_t>(contact.key.tool_sphere)];
    const double lever = std::max(contact.gap + sphere.r, 1e-4);
    CHECK((change.direction(contact.nhat_OG_W) - other->nhat_OG_W).norm() * lever <= 4 * tolerance);
    ++other;
  }
  for (; other != from_b.end(); ++other) CHECK(other->gap >= kMargin - tolerance);
  return from_a.size();
}

void map_points(SceneParts& parts, const std::function<Vector3(const Vector3&)>& map_W) {
  for (Capsule& capsule : parts.capsules_W) {
    capsule.p_A = map_W(capsule.p_A);
    capsule.p_B = map_W(capsule.p_B);
  }
}

/// A random order of 0 .. count - 1.
std::vector<std::size_t> random_order(SplitMix64& random, std::size_t count) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t i = count; i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  return order;
}

template <typename T>
std::vector<T> reordered(const std::vector<T>& items, const std::vector<std::size_t>& order) {
  std::vector<T> result;
  result.reserve(items.size());
  for (const std::size_t i : order) result.push_back(items[i]);
  return result;
}

void scale_lengths(SceneParts& parts, double unit) {
  const auto scale = [unit](Sphere& sphere) { sphere = {sphere.p * unit, sphere.r * unit}; };
  std::for_each(parts.tool_G.begin(), parts.tool_G.end(), scale);
  for (SceneParts::Body& body : parts.bodies) {
    std::for_each(body.spheres_B.begin(), body.spheres_B.end(), scale);
    body.X_WB.p *= unit;
  }
  map_points(parts, [unit](const Vector3& p) { return Vector3(p * unit); });
  for (Capsule& capsule : parts.capsules_W) capsule.r *= unit;
  parts.X_WG.p *= unit;
}

/// Runs `check(random, parts)` on many scenes and demands that some contacts were seen.
template <typename Check>
void for_scenes(std::uint64_t seed, const Check& check) {
  SplitMix64 random(seed);
  std::size_t contacts = 0;
  for (std::int64_t trial = 0; trial < scaled(1'000); ++trial) {
    const SceneParts parts = random_parts(random);
    contacts += check(random, parts);
  }
  CHECK(contacts > 10);
}

constexpr double kTolerance = 1e-14;

}  // namespace

TEST_CASE("the order of tool spheres, strings, bodies and their spheres does not change contacts") {
  for_scenes(1, [](SplitMix64& random, const SceneParts& parts) {
    SceneParts permuted = parts;
    const auto tool = random_order(random, parts.tool_G.size());
    const auto capsules = random_order(random, parts.capsules_W.size());
    const auto bodies = random_order(random, parts.bodies.size());
    permuted.tool_G = reordered(parts.tool_G, tool);
    permuted.capsules_W = reordered(parts.capsules_W, capsules);
    permuted.bodies = reordered(parts.bodies, bodies);
    std::vector<std::vector<std::size_t>> spheres;
    for (SceneParts::Body& body : permuted.bodies) {
      spheres.push_back(random_order(random, body.spheres_B.size()));
      body.spheres_B = reordered(body.spheres_B, spheres.back());
    }
    const auto at = [](const std::vector<std::size_t>& order, std::int32_t i) {
      return static_cast<std::int32_t>(order[static_cast<std::size_t>(i)]);
    };
    Change change;
    change.key = [&](const ContactKey& key) {
      if (key.kind == ObstacleKind::kCapsule) {
        return ContactKey{key.kind, at(capsules, key.obstacle), at(tool, key.tool_sphere), 0};
      }
      const auto& order = spheres[static_cast<std::size_t>(key.obstacle)];
      return ContactKey{key.kind, at(bodies, key.obstacle), at(tool, key.tool_sphere),
                        at(order, key.obstacle_sphere)};
    };
    // Each pair is computed by itself: not even rounding may differ.
    return check_same(parts, permuted, change, 0.0);
  });
}

TEST_CASE("a mirrored scene has the mirrored contacts") {
  for_scenes(2, [](SplitMix64&, const SceneParts& parts) {
    SceneParts mirrored = parts;
    const auto mirror = [](const Vector3& p) { return Vector3(p.x(), p.y(), -p.z()); };
    const auto mirror_pose = [&](Pose& X) {
      X = {{X.q.w(), -X.q.x(), -X.q.y(), X.q.z()}, mirror(X.p)};
    };
    for (Sphere& sphere : mirrored.tool_G) sphere.p = mirror(sphere.p);
    for (SceneParts::Body& body : mirrored.bodies) {
      for (Sphere& sphere : body.spheres_B) sphere.p = mirror(sphere.p);
      mirror_pose(body.X_WB);
    }
    map_points(mirrored, mirror);
    mirror_pose(mirrored.X_WG);
    Change change;
    change.direction = mirror;
    return check_same(parts, mirrored, change, kTolerance);
  });
}

TEST_CASE("a scene moved by a kilometre and turned has the turned contacts") {
  for_scenes(3, [](SplitMix64& random, const SceneParts& parts) {
    SceneParts far = parts;
    const Pose X_MW{random_rotation(random), 1000.0 * to_vector(random.direction())};
    for (SceneParts::Body& body : far.bodies) body.X_WB = compose(X_MW, body.X_WB);
    map_points(far, [&](const Vector3& p) { return transform(X_MW, p); });
    far.X_WG = compose(X_MW, far.X_WG);
    Change change;
    change.direction = [&](const Vector3& n) { return Vector3(X_MW.q * n); };
    // Positions at 1 km have a last bit of 1.1e-13 m.
    return check_same(parts, far, change, 1e-12);
  });
}

TEST_CASE("millimetres, micrometres or megametres instead of metres find the same contacts") {
  for (const double unit : {1000.0, 1e-6, 1e6, 1e-100, 1e100}) {
    CAPTURE(unit);
    for_scenes(4, [&](SplitMix64&, const SceneParts& parts) {
      SceneParts in_unit = parts;
      scale_lengths(in_unit, unit);
      Change change;
      change.unit = unit;
      return check_same(parts, in_unit, change, kTolerance);
    });
  }
}

TEST_CASE("a unit that is a power of two changes no bit of any contact but the unit") {
  for_scenes(5, [](SplitMix64& random, const SceneParts& parts) {
    const double unit = random.chance(0.5) ? 0x1p40 : 0x1p-200;
    SceneParts in_unit = parts;
    scale_lengths(in_unit, unit);
    const auto a = found_contacts(CheckedScene(parts), parts.X_WG, {kMargin});
    const auto b = found_contacts(CheckedScene(in_unit), in_unit.X_WG, {kMargin * unit});
    REQUIRE(a->contacts.size() == b->contacts.size());
    CHECK(a->minimum_gap == b->minimum_gap / unit);
    for (std::size_t i = 0; i < a->contacts.size(); ++i) {
      Contact scaled_back = b->contacts[i];
      scaled_back.gap /= unit;
      scaled_back.p_WC /= unit;
      CHECK(same_bits(a->contacts[i], scaled_back));
    }
    return a->contacts.size();
  });
}

TEST_CASE("a string named from its other end has the same contacts") {
  for_scenes(6, [](SplitMix64&, const SceneParts& parts) {
    SceneParts reversed = parts;
    for (Capsule& capsule : reversed.capsules_W) std::swap(capsule.p_A, capsule.p_B);
    return check_same(parts, reversed, {}, kTolerance);
  });
}

TEST_CASE("q and -q of tool and body give the same bits") {
  for_scenes(7, [](SplitMix64&, const SceneParts& parts) {
    SceneParts negated = parts;
    negated.X_WG.q.coeffs() *= -1.0;
    for (SceneParts::Body& body : negated.bodies) body.X_WB.q.coeffs() *= -1.0;
    const auto a = found_contacts(CheckedScene(parts), parts.X_WG, {kMargin});
    const auto b = found_contacts(CheckedScene(negated), negated.X_WG, {kMargin});
    REQUIRE(a->contacts.size() == b->contacts.size());
    for (std::size_t i = 0; i < a->contacts.size(); ++i)
      CHECK(same_bits(a->contacts[i], b->contacts[i]));
    return a->contacts.size();
  });
}

}  // namespace hapticd::test
