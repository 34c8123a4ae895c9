// One tool sphere against one capsule or one body sphere: gaps, normals and points that are known
// in closed form, and the extremes of radius, length and place.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "core/math/rotation.h"
#include "tests/core/collision/scene_check.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kTip = 5e-3;
constexpr double kString = 0.34e-3;
constexpr QueryOptions kWide{10.0};

/// Contact of one tool sphere of radius `r` at `p_WC` with one capsule.
Contact contact_with(const Capsule& capsule, const Vector3& p_WC, double r,
                     const QueryOptions& options = kWide) {
  CheckedScene scene;
  scene.set_tool({{{0, 0, 0}, r}});
  scene.capsules = {capsule};
  const auto set = found_contacts(scene, {{1, 0, 0, 0}, p_WC}, options);
  REQUIRE(set->contacts.size() == 1);
  CHECK(set->minimum_gap == set->contacts[0].gap);
  CHECK(set->contacts[0].key == ContactKey{ObstacleKind::kCapsule, 0, 0, 0});
  return set->contacts[0];
}

const Capsule kAlongX{{0, 0, 0}, {1, 0, 0}, kString};

/// Any unit vector normal to the unit vector `n`.
Vector3 normal_to(const Vector3& n) {
  return n.cross(std::abs(n.x()) < 0.6 ? Vector3(1, 0, 0) : Vector3(0, 1, 0)).normalized();
}

}  // namespace

TEST_CASE("beside a string the gap is the distance less both radii, along the line of centres") {
  for (const double x : {1e-9, 0.1, 0.5, 0.9999}) {
    const Contact c = contact_with(kAlongX, {x, 6e-3, -8e-3}, kTip);
    CHECK(c.gap == within(10e-3 - kTip - kString, 1e-13));
    CHECK((c.nhat_OG_W - Vector3(0, 0.6, -0.8)).norm() <= 1e-15);
    CHECK((c.p_WC - Vector3(x, 3e-3, -4e-3)).norm() <= 1e-15);
    CHECK(c.lambda == within(x, 1e-15));
  }
}

TEST_CASE("beyond its end a string is a ball around the end") {
  const Contact at_B = contact_with(kAlongX, {1.0 + 6e-3, 8e-3, 0}, kTip);
  CHECK(at_B.gap == within(10e-3 - kTip - kString, 1e-12));
  CHECK((at_B.nhat_OG_W - Vector3(0.6, 0.8, 0)).norm() <= 1e-13);
  CHECK((at_B.p_WC - Vector3(1.003, 4e-3, 0)).norm() <= 1e-15);
  CHECK(at_B.lambda == 1.0);
  const Contact at_A = contact_with(kAlongX, {-6e-3, 0, -8e-3}, kTip);
  CHECK(at_A.gap == within(10e-3 - kTip - kString, 1e-13));
  CHECK((at_A.nhat_OG_W - Vector3(-0.6, 0, -0.8)).norm() <= 1e-15);
  CHECK(at_A.lambda == 0.0);
}

TEST_CASE("gap and normal pass over lambda 0 and 1 without a step, from just inside to outside") {
  // The normal turns by at most the way over the distance, whichever side of the seam.
  const double height = 4e-3;
  for (const double end : {0.0, 1.0}) {
    for (const double r : {0.0, kString, 3e-3}) {
      const Capsule capsule{{0, 0, 0}, {1, 0, 0}, r};
      Contact before = contact_with(capsule, {end - 1e-5, height, 0}, kTip);
      for (int i = 1; i <= 200; ++i) {
        const Contact now = contact_with(capsule, {end - 1e-5 + 1e-7 * i, height, 0}, kTip);
        CHECK((now.nhat_OG_W - before.nhat_OG_W).norm() <= 1.0001 * 1e-7 / height);
        CHECK(std::abs(now.gap - before.gap) <= 1e-7 * 1e-5 / height + 1e-17);
        before = now;
      }
    }
    for (const double step : {0.0, 1e-18, 1e-16, 1e-12}) {
      for (const double side : {-1.0, 1.0}) {
        const Contact c = contact_with(kAlongX, {end + side * step, height, 0}, kTip);
        CHECK(std::abs(c.lambda - end) < 1e-11);
        CHECK(c.gap == within(height - kTip - kString, 1e-12));
        CHECK((c.nhat_OG_W - Vector3(0, 1, 0)).norm() <= 1e-9);
      }
    }
  }
}

TEST_CASE("a centre on the axis is as deep as both radii and leaves along the fixed normal") {
  for (const double x : {0.0, 0.25, 0.5, 1.0}) {
    const Contact c = contact_with(kAlongX, {x, 0, 0}, kTip);
    CHECK(c.gap == -(kTip + kString));
    CHECK(c.nhat_OG_W == Vector3(0, 1, 0));
    CHECK(c.lambda == x);
    CHECK((c.p_WC - Vector3(x, -kTip, 0)).norm() <= 1e-17);
    const Contact reversed = contact_with({{1, 0, 0}, {0, 0, 0}, kString}, {x, 0, 0}, kTip);
    CHECK(reversed.nhat_OG_W == Vector3(0, 1, 0));
    CHECK(reversed.lambda == 1.0 - x);
  }
}

TEST_CASE("the way out of an axis does not depend on how the tool is turned") {
  SplitMix64 random(1);
  CheckedScene scene;
  scene.set_tool({{{0, 0, 0}, kTip}});
  scene.capsules = {{{0, 0, 0}, {0, 0, 2}, kString}};
  for (int i = 0; i < 200; ++i) {
    const auto set = found_contacts(scene, {random_rotation(random), {0, 0, 0.5}}, {});
    REQUIRE(set->contacts.size() == 1);
    CHECK(set->contacts[0].nhat_OG_W == Vector3(0, 1, 0));
    CHECK(set->contacts[0].gap == -(kTip + kString));
  }
}

TEST_CASE("a string of no length is a ball") {
  SplitMix64 random(2);
  for (int i = 0; i < 500; ++i) {
    const Vector3 p_A = random_vector(random, 1.0);
    const Vector3 n = to_vector(random.direction());
    const double d = i == 0 ? 0.0 : random.uniform(0.0, 0.02);
    const Contact c = contact_with({p_A, p_A, kString}, p_A + d * n, kTip);
    CHECK(c.gap == within(d - kTip - kString, 1e-12));
    CHECK(c.lambda == 0.0);
    if (i > 0) CHECK((c.nhat_OG_W - n).norm() * d <= 4e-16);
    if (i == 0) CHECK(c.nhat_OG_W == Vector3(0, 1, 0));
  }
}

TEST_CASE("radii of 0 on either side or both are legal") {
  for (const double r : {0.0, kTip}) {
    for (const double R : {0.0, 1e-9, 1.0}) {
      CAPTURE(r);
      CAPTURE(R);
      const Contact c = contact_with({{0, 0, 0}, {1, 0, 0}, R}, {0.5, 0, 0.02}, r);
      CHECK(c.gap == within(0.02 - r - R, 1e-14));
      CHECK((c.p_WC - Vector3(0.5, 0, 0.02 - r)).norm() <= 1e-17);
    }
  }
  // A point on a bare segment touches it, and still has a way out.
  const Contact touching = contact_with({{0, 0, 0}, {1, 0, 0}, 0.0}, {0.5, 0, 0}, 0.0);
  CHECK(touching.gap == 0.0);
  CHECK(touching.nhat_OG_W == Vector3(0, 1, 0));
}

TEST_CASE("any radius, length and ratio gives the gap of the nearest point to a millionth") {
  SplitMix64 random(3);
  for (const double R : {0.0, 1e-9, 1e-4, 1.0}) {
    for (const double L : {1e-6, 1e-3, 1.1, 1e3, 1e5, 1e7}) {
      CAPTURE(R);
      CAPTURE(L);
      const double s = kTip + R;
      for (std::int64_t i = 0; i < scaled(300); ++i) {
        const Vector3 along = to_vector(random.direction());
        const Vector3 across = normal_to(along);
        const double depth = random.uniform(-0.9, 0.9) * s;
        // Near the middle, where the truth is known without the length, at W's origin.
        const Capsule capsule{-0.5 * L * along, 0.5 * L * along, R};
        const Vector3 p_WC = random.uniform(-0.3, 0.3) * std::min(L, 1.0) * along;
        const Contact c = contact_with(capsule, p_WC + (s - depth) * across, kTip);
        // Ends at 5e6 m are themselves rounded to 1e-9 m, a fifth of what is allowed.
        CHECK(std::abs(c.gap + depth) <= 1e-6 * s);
        CHECK((c.nhat_OG_W - across).norm() * (s - depth) <= 1e-6 * s);
      }
    }
  }
}

TEST_CASE("strings a tenth of a millionth apart in direction each have their own true gap") {
  SplitMix64 random(4);
  for (std::int64_t trial = 0; trial < scaled(500); ++trial) {
    CheckedScene scene;
    scene.set_tool(random_cluster(random, 30, 0.05, 1e-3, 8e-3));
    const Vector3 along = to_vector(random.direction());
    for (int k = 0; k < 4; ++k) {
      const Vector3 turned = along + 1e-7 * random_vector(random, 1.0);
      scene.capsules.push_back({-0.5 * turned, 0.5 * turned, kString});
    }
    check_against_oracle(scene, {random_rotation(random), random_vector(random, 0.03)}, {});
  }
}

TEST_CASE("two spheres have the gap of their centres less both radii, wherever the body stands") {
  SplitMix64 random(5);
  for (int i = 0; i < 500; ++i) {
    const Vector3 p_BC = random_vector(random, 0.2);
    const Pose X_WB{random_rotation(random), random_vector(random, 1.0)};
    const Vector3 n = to_vector(random.direction());
    const double R = random.uniform(0.0, 0.1);
    const double d = random.uniform(1e-6, 0.2);
    const Vector3 p_GC = random_vector(random, 0.1);
    const Quaternion q_WG = random_rotation(random);
    CheckedScene scene;
    scene.set_tool({{p_GC, kTip}});
    scene.add_body({{p_BC, R}}, X_WB);
    const Vector3 p_WP = transform(X_WB, p_BC);
    const auto set = found_contacts(scene, {q_WG, p_WP + d * n - q_WG * p_GC}, kWide);
    REQUIRE(set->contacts.size() == 1);
    const Contact& c = set->contacts[0];
    CHECK(c.key == ContactKey{ObstacleKind::kBody, 0, 0, 0});
    CHECK(std::abs(c.gap - (d - R - kTip)) <= 1e-14);
    CHECK((c.nhat_OG_W - n).norm() * d <= 1e-14);
    CHECK((c.p_WC - (p_WP + (d - kTip) * n)).norm() <= 1e-14);
    CHECK(c.lambda == 0.0);
  }
}

TEST_CASE("concentric spheres part upwards, as deep as both radii") {
  SplitMix64 random(6);
  for (int i = 0; i < 50; ++i) {
    CheckedScene scene;
    scene.set_tool({{{0, 0, 0}, kTip}});
    const Vector3 p = random_vector(random, 1.0);
    scene.add_body({{{0, 0, 0}, 0.03}}, {random_rotation(random), p});
    const auto set = found_contacts(scene, {random_rotation(random), p}, {});
    REQUIRE(set->contacts.size() == 1);
    CHECK(set->contacts[0].nhat_OG_W == Vector3(0, 1, 0));
    CHECK(set->contacts[0].gap == -(kTip + 0.03));
    CHECK(set->minimum_gap == -(kTip + 0.03));
  }
}

TEST_CASE("a tool deep inside a body of any make is as deep as the oracle says") {
  SplitMix64 random(7);
  for (std::int64_t trial = 0; trial < scaled(300); ++trial) {
    CheckedScene scene;
    scene.set_tool(random_cluster(random, 1 + static_cast<int>(random.below(25)), 0.01, 0.0, 4e-3));
    // Around the tool: one huge sphere, a heap of large ones, a hollow shell that does not touch.
    if (trial % 3 == 0) scene.add_body({{{0.1, 0, 0}, 100.0}}, {});
    if (trial % 3 == 1) scene.add_body(random_cluster(random, 60, 0.05, 0.03, 0.2), {});
    if (trial % 3 == 2) scene.add_body(blob_spheres(500), {});
    const Pose X_WG{random_rotation(random), random_vector(random, 2e-3)};
    check_against_oracle(scene, X_WG, {});
  }
}

TEST_CASE("quaternions that are not quite unit turn the tool without stretching it") {
  CheckedScene scene;
  scene.set_tool({{{1.0, 0, 0}, kTip}});
  scene.capsules = {{{0, -1, -1}, {0, -1, 1}, kString}};
  // A quarter turn about z takes the sphere to +-y.
  const double h = std::sqrt(0.5);
  for (const double stretch : {1.0, 1.0 + 1e-9, 1.0 - 1e-9, 0.5, 2.0}) {
    const auto set = found_contacts(scene, {{h * stretch, 0, 0, -h * stretch}, {0, 2e-3, 0}}, {});
    REQUIRE(set->contacts.size() == 1);
    CHECK(set->contacts[0].gap == within(2e-3 - kTip - kString, 1e-12));
  }
}

}  // namespace hapticd::test
