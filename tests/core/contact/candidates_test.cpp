// What the candidates say they know, while the tool moves on from where they were found. Truth: the
// distance of every pair of tool sphere and line by itself.
#include "core/contact/candidates.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/core/contact/rendering_fixture.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

constexpr double kRadius = 4e-3;
constexpr double kLine = 1e-3;
constexpr int kLines = 60;

/// A finger of two spheres over lines along x.
RenderingScene comb(SplitMix64& random) {
  RenderingScene scene({{{0, 0, 0}, kRadius}, {{0, 0, 0.01}, kRadius}});
  for (int k = 0; k < kLines; ++k) {
    const double y = random.uniform(-0.03, 0.0);
    const double z = random.uniform(-0.03, 0.03);
    scene.capsules_W.push_back({{-1.0, y, z}, {1.0, y, z}, kLine});
  }
  return scene;
}

/// Gap of a tool sphere and a line along x, no end of which is near.
double true_gap(const RenderingScene& scene, const Pose& X_WG, const ContactKey& key) {
  const Sphere& sphere = scene.tool_spheres[static_cast<std::size_t>(key.tool_sphere)];
  const Vector3 p_WC = X_WG.p + X_WG.q * sphere.p;
  const Vector3& p_A = scene.capsules_W[static_cast<std::size_t>(key.obstacle)].p_A;
  return std::hypot(p_WC.y() - p_A.y(), p_WC.z() - p_A.z()) - sphere.r - kLine;
}

bool lists(const Candidates& candidates, const ContactKey& key) {
  const auto& contacts = candidates.contacts().contacts;
  return std::any_of(contacts.begin(), contacts.end(),
                     [&](const Contact& contact) { return contact.key == key; });
}

bool lists_all_within(double distance, const Candidates& candidates, const RenderingScene& scene,
                      const Pose& X_WG) {
  for (std::int32_t line = 0; line < kLines; ++line) {
    for (const TreeSphereId sphere : {0, 1}) {
      const ContactKey key{ObstacleKind::kCapsule, line, sphere, 0};
      if (true_gap(scene, X_WG, key) < distance && !lists(candidates, key)) return false;
    }
  }
  return true;
}

}  // namespace

TEST_CASE("what candidates see is listed, however far the tool has gone") {
  SplitMix64 random(5);
  int seen = 0;
  int unseen = 0;
  int dismissed = 0;
  for (int round = 0; round < 60; ++round) {
    const RenderingScene scene = comb(random);
    ToolRun run(scene, pose_at({0, 7e-3, 0}));
    run.asked = run.input(pose_at({0, 7e-3, 0}));
    ContactResult result;
    Candidates candidates;
    candidates.begin(run.asked.options.margin, true);
    candidates.query({run.asked, run.state}, 0.0, result);
    for (int step = 0; step < 20; ++step) {
      const Vector3 way = random.uniform(0.0, 1e-3) * to_vector(random.direction());
      run.state.X_WG.p += way;
      candidates.moved(way.norm());
      const double distance = random.uniform(0.0, 6e-3);
      const bool sees = candidates.sees(distance);
      (sees ? seen : unseen) += 1;
      if (sees) REQUIRE(lists_all_within(distance, candidates, scene, run.state.X_WG));
      for (const Contact& contact : candidates.contacts().contacts) {
        if (candidates.may_be_within(contact, distance)) continue;
        ++dismissed;
        REQUIRE(true_gap(scene, run.state.X_WG, contact.key) > distance - 1e-12);
      }
    }
  }
  CHECK(seen > 100);
  CHECK(unseen > 100);
  CHECK(dismissed > 100);
}

TEST_CASE("candidates of this configuration are looked at no second time") {
  SplitMix64 random(6);
  const RenderingScene scene = comb(random);
  ToolRun run(scene, pose_at({0, 0.01, 0}));
  run.asked = run.input(pose_at({0, 0.01, 0}));
  ContactResult result;
  Candidates candidates;
  candidates.begin(run.asked.options.margin, true);
  candidates.query({run.asked, run.state}, 0.0, result);
  const std::int64_t tests = result.tests;
  candidates.refresh({run.asked, run.state}, 0.0, result);
  CHECK(result.queries == 1);
  CHECK(result.tests == tests);
  CHECK(candidates.tests_of_next_look() == 0);
  candidates.moved(run.asked.options.margin);
  CHECK(candidates.tests_of_next_look() > 0);
  candidates.refresh({run.asked, run.state}, 0.0, result);
  CHECK(result.queries == 2);
}

}  // namespace hapticd::test
