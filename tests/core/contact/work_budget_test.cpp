// The work budget of a tick: whatever it is, the tool only lags. Truths: the exhaustive oracle on
// the committed path, the same tick with one linearisation less, the same session without a budget,
// and the hand's own motion for what a force may change by.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/contact/tick_work.h"
#include "tests/core/contact/rendering_fixture.h"
#include "tests/core/contact/session_run.h"
#include "tests/core/contact/strokes.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kRate = 1000.0;
/// Allowed depth of the committed path, m.
constexpr long double kAllowedDepth = 1e-6L;
/// Change of force per tick that a contact switch may always make, N, and its share of kt |v| dt.
constexpr double kFreeChange = 0.15;
constexpr double kExcess = 1.1;

/// From what never suffices to what nearly always does.
std::int64_t random_budget(SplitMix64& random) {
  std::int64_t budget = 1;
  for (std::uint64_t k = random.below(6); k > 0; --k) budget *= 10;
  return budget;
}

/// A tool in the scene of a session.
struct Played {
  RenderingScene scene;
  ContactSession session;

  explicit Played(const ContactSession& from) : scene(from.tool_G), session(from) {
    scene.capsules_W = session.capsules_W;
    for (const SessionBody& body : session.bodies) {
      scene.add_body(body.spheres_B, pose_at(body.p_WB));
    }
  }
  [[nodiscard]] Pose X_WH(int tick) const {
    const SessionPose at = session.X_WH(tick / kRate);
    return pose_at(at.p_WH, at.phi_WH);
  }
  [[nodiscard]] int ticks() const { return static_cast<int>(session.seconds * kRate); }
};

bool same(const ToolRun& a, const ToolRun& b) {
  return a.state.X_WG.p == b.state.X_WG.p && a.state.X_WG.q.coeffs() == b.state.X_WG.q.coeffs() &&
         a.result.F_H_W.f == b.result.F_H_W.f && a.result.F_H_W.t == b.result.F_H_W.t &&
         tick_work(a.result) == tick_work(b.result);
}

/// Deepest point of the path of a stroke whose every tick has another budget, m.
long double deepest_point(const Stroke& stroke, std::uint64_t seed, std::int64_t& cut) {
  SplitMix64 random(seed);
  ToolRun run(stroke.scene, stroke.X_WH.front());
  long double deepest = 1.0L;
  for (const Pose& X_WH : stroke.X_WH) {
    run.work_budget = random_budget(random);
    deepest = std::min(deepest, run.tick_along(X_WH));
    if (run.result.status == ContactStatus::kLagging) ++cut;
  }
  return deepest;
}

/// n x n spheres in a plane.
std::vector<Sphere> flat_tool(int n) {
  std::vector<Sphere> spheres;
  spheres.reserve(static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
  for (int i = 0; i < n * n; ++i) {
    const double x = 2.0 * (i % n) / (n - 1) - 1.0;
    const double z = 2.0 * static_cast<int>(i / n) / (n - 1) - 1.0;
    spheres.push_back({{0.03 * x, 0, 0.03 * z}, 5e-3});
  }
  return spheres;
}

}  // namespace

TEST_CASE("with any work budget no stroke sinks in or passes through by more than a micrometre") {
  long double deepest = 1.0L;
  std::int64_t cut = 0;
  for (std::int64_t i = 0; i < scaled(4000); ++i) {
    const auto seed = static_cast<std::uint64_t>(i);
    const Stroke stroke = i % 2 == 0 ? make_stroke(seed) : make_string_stroke(seed);
    const long double gap = deepest_point(stroke, seed, cut);
    deepest = std::min(deepest, gap);
    if (gap < -kAllowedDepth) {
      FAIL_CHECK("stroke " << i << ": " << static_cast<double>(gap) << " m, " << stroke.describe());
    }
  }
  MESSAGE("deepest point " << static_cast<double>(deepest) << " m, " << cut << " ticks lag");
  CHECK(cut > scaled(4000));
}

TEST_CASE("the work of a tick ends within its budget and one linearisation") {
  SplitMix64 random(7);
  std::int64_t cut = 0;
  for (const ContactSession& session : contact_sessions()) {
    const Played played(session);
    ToolRun run(played.scene, played.X_WH(0));
    ToolRun less(played.scene, played.X_WH(0));
    for (int tick = 0; tick < played.ticks(); ++tick) {
      less.state = run.state;
      less.work_budget = run.work_budget = random_budget(random);
      run.tick(played.X_WH(tick));
      if (run.result.cut_short) {
        ++cut;
        CHECK(run.result.status == ContactStatus::kLagging);
      }
      if (run.result.sub_steps < 2) continue;
      less.options.sub_steps = run.result.sub_steps - 1;
      less.tick(played.X_WH(tick));
      CHECK(tick_work(less.result) <= run.work_budget);
    }
  }
  CHECK(cut > 100);
}

TEST_CASE("a budget that is never used up changes no bit") {
  for (const ContactSession& session : contact_sessions()) {
    const Played played(session);
    ToolRun free(played.scene, played.X_WH(0));
    ToolRun bounded(played.scene, played.X_WH(0));
    bounded.work_budget = std::int64_t{1} << 60;
    for (int tick = 0; tick < played.ticks(); ++tick) {
      free.tick(played.X_WH(tick));
      bounded.tick(played.X_WH(tick));
      REQUIRE(same(free, bounded));
      REQUIRE_FALSE(bounded.result.cut_short);
    }
  }
}

TEST_CASE("the error of the force falls as the budget grows, to five percent, and then vanishes") {
  for (const ContactSession& session : contact_sessions()) {
    CAPTURE(std::string(session.name));
    const SessionRun reference = play(session, reference_options(), kRate);
    double before = 1e9;
    double smallest = 1e9;
    for (const std::int64_t budget : {1L, 3'000L, 6'000L, 12'000L, 25'000L, 50'000L, 0L}) {
      const SessionRun run = play(session, ContactOptions{}, kRate, nullptr, budget);
      const double error = force_error(run.f_H_W, reference.f_H_W).rms_percent;
      MESSAGE(std::string(session.name) << " " << budget << ": " << error << " %, most work "
                                        << *std::max_element(run.work.begin(), run.work.end()));
      CHECK(error <= 1.05 * before + 1e-3);
      before = error;
      smallest = std::min(smallest, error);
    }
    CHECK(before <= 1.05 * smallest + 1e-3);
  }
}

TEST_CASE(
    "where a budget cuts, and where it comes back, the force steps no more than at a contact") {
  double worst = 0.0;
  int judged = 0;
  int ticks = 0;
  for (const ContactSession& session : contact_sessions()) {
    CAPTURE(std::string(session.name));
    const Played played(session);
    SplitMix64 random(11);
    ToolRun free(played.scene, played.X_WH(0));
    ToolRun run(played.scene, played.X_WH(0));
    Vector3 f{0, 0, 0};
    Vector3 f_free{0, 0, 0};
    int slip = 0;
    ticks += played.ticks();
    for (int tick = 0; tick < played.ticks(); ++tick) {
      const Pose X_WH = played.X_WH(tick);
      const ToolMotion hand = motion_between(played.X_WH(std::max(tick - 1, 0)), X_WH);
      const double way = displacement_bound(hand, reach(played.scene.tool()));
      const double allowed = std::max(kFreeChange, kExcess * run.stiffness.kt * way);
      if (tick % 7 == 0) run.work_budget = random_budget(random);
      free.tick(X_WH);
      run.tick(X_WH);
      // Where the tool slips, or is about to, the force turns by itself, and one that lags catches
      // up on that too.
      slip = 2.0 * (free.result.F_H_W.f - f_free).norm() > allowed ? 20 : slip - 1;
      if (slip <= 0) {
        ++judged;
        worst = std::max(worst, (run.result.F_H_W.f - f).norm() / allowed);
      }
      f = run.result.F_H_W.f;
      f_free = free.result.F_H_W.f;
    }
  }
  MESSAGE("greatest change of force over what a contact may make: " << worst << ", in " << judged
                                                                    << " of " << ticks);
  CHECK(judged > 0.7 * ticks);
  CHECK(worst <= 1.0);
}

TEST_CASE("a tool in a crowd leaves out what is far, and comes to the same force by less work") {
  RenderingScene scene(flat_tool(40));
  scene.add_body({{{0, 0, 0}, 1e4}}, pose_at({0, -1e4, 0}));
  const Pose above = pose_at({0, 6e-3, 0}, {0.05, 0, 0.03});
  const Pose pressed = pose_at({0, 3e-3, 0}, {0.05, 0, 0.03});
  ToolRun free(scene, above);
  ToolRun run(scene, above);
  run.work_budget = 8'000;
  std::int64_t free_work = 0;
  std::int64_t work = 0;
  for (int tick = 0; tick < 200; ++tick) {
    const Pose X_WH = between(above, pressed, std::min(1.0, tick / 100.0));
    free.tick(X_WH);
    run.tick(X_WH);
    free_work += tick_work(free.result);
    work += tick_work(run.result);
    CHECK(run.problem->candidates().contacts().contacts.size() <=
          free.problem->candidates().contacts().contacts.size());
  }
  CHECK(free.result.F_H_W.f.norm() > 1.0);
  CHECK((free.result.F_H_W.f - run.result.F_H_W.f).norm() < 0.01 * free.result.F_H_W.f.norm());
  MESSAGE("work " << work << " of " << free_work);
  CHECK(4 * work < 3 * free_work);
}

TEST_CASE("a tool that is swept over much looks around anew only where the budget pays for it") {
  RenderingScene scene(flat_tool(12));
  std::vector<Sphere> ground;
  ground.reserve(std::size_t{200} * 40);
  for (int i = 0; i < 200 * 40; ++i) {
    ground.push_back({{4e-3 * (i % 200), 0, 4e-3 * static_cast<int>(i / 200)}, 4e-3});
  }
  scene.add_body(ground, pose_at({-0.05, -4e-3, -0.08}));
  int ticks = 0;
  int over = 0;
  int cut = 0;
  for (const std::int64_t budget : {5'000, 7'000, 10'000, 14'000, 20'000, 30'000, 45'000, 70'000}) {
    ToolRun run(scene, pose_at({0, 6e-3, 0}));
    run.work_budget = budget;
    for (int tick = 0; tick < 60; ++tick) {
      run.tick(pose_at({0.01 * tick, 6e-3 - 1e-4 * tick, 0}));
      cut += run.result.cut_short ? 1 : 0;
      if (run.result.sub_steps < 2) continue;
      ++ticks;
      over += 10 * tick_work(run.result) > 11 * budget ? 1 : 0;
    }
  }
  MESSAGE(over << " of " << ticks << " ticks of more than one linearisation beyond their budgets, "
               << cut << " cut short");
  CHECK(ticks > 50);
  CHECK(8 * over < ticks);
  CHECK(cut > 50);
}

TEST_CASE("what is pressed keeps its level until it is let go of") {
  RenderingScene scene({{{0, 0, 0}, 5e-3}});
  std::vector<Sphere> plate;
  plate.reserve(400);
  for (int x = -10; x < 10; ++x) {
    for (int z = -10; z < 10; ++z) plate.push_back({{4e-3 * x, 0, 4e-3 * z}, 5e-3});
  }
  scene.add_body(plate, pose_at({0, -5e-3, 0}));
  const Pose above = pose_at({0, 0.1, 0});
  const Pose pressed = pose_at({0, 4e-3, 0});
  ToolRun fine(scene, above);
  fine.hold(pressed, 50);
  ToolRun run(scene, above);
  run.options.body_level = 1;
  run.hold(pressed, 50);
  const double coarse = run.result.F_H_W.f.norm();
  const double exact = fine.result.F_H_W.f.norm();
  REQUIRE(exact > 0.5);
  REQUIRE(coarse > exact + 2 * kFreeChange);
  run.options.body_level = kLeafLevel;
  CHECK(run.hold(pressed, 1).F_H_W.f.norm() == within(coarse, 1e-6));
  run.hold(above, 2);
  CHECK(run.hold(pressed, 50).F_H_W.f.norm() == within(exact, 1e-3));
}

}  // namespace hapticd::test
