// The table of extremes for strings that a tool touches: one row, one test. Whatever the string,
// the pose or the edit of the scene: nothing is NaN, nothing is entered, and no force exceeds what
// kt explains.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/simulation/tool_renderer.h"
#include "tests/core/contact/string_scenes.h"
#include "tests/core/contact/strokes.h"
#include "tests/support/guarded_step.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr long double kAllowedDepth = 1e-6L;

/// What a string that was bent may give beyond the pull of the hand while it straightens, N.
constexpr double kStoredForce = 0.2;

bool finite(const ToolRun& run) {
  bool all = run.result.F_H_W.f.allFinite() && run.result.F_H_W.t.allFinite() &&
             run.state.X_WG.p.allFinite() && run.state.X_WG.q.coeffs().allFinite();
  for (const TouchedString& hold : run.state.touched) {
    all = all && hold.bend.u_W.allFinite() && std::isfinite(hold.bend.lambda) &&
          hold.slip_W.allFinite() && std::isfinite(hold.normal_force);
  }
  return all;
}

/// Moves the hand to each place in turn, `ticks` ticks each, and judges every tick.
void check_way(ToolRun& run, const std::vector<Vector3>& places, int ticks) {
  for (std::size_t k = 1; k < places.size(); ++k) {
    for (int i = 1; i <= ticks; ++i) {
      const Vector3 p_WH =
          places[k - 1] + (places[k] - places[k - 1]) * (static_cast<double>(i) / ticks);
      const double pulled_before = (p_WH - run.state.X_WG.p).norm();
      const long double gap = run.tick_along(pose_at(p_WH));
      REQUIRE(finite(run));
      CHECK(gap >= -kAllowedDepth);
      const double pulled =
          run.stiffness.kt * std::max(pulled_before, (p_WH - run.state.X_WG.p).norm());
      const Vector3 f = rendered(run).F_H_W.f;
      REQUIRE(f.allFinite());
      CHECK(f.norm() <= 1.01 * pulled + kStoredForce);
    }
  }
}

/// Down on, sideways over, along and off a string.
std::vector<Vector3> playing(double x, double s) {
  return {{x, s + 3e-3, 0.2e-3},     {x, s - 2e-3, 0.2e-3},       {x, s - 4e-3, 3e-3},
          {x + 5e-3, s - 1e-3, 0.0}, {x + 5e-3, -s - 3e-3, 1e-3}, {x, s + 3e-3, -9e-3}};
}

}  // namespace

TEST_CASE("strings without tension, stiffness, width or length stay finite and are not entered") {
  for (const double tension : {0.0, 1e-9, 30.0, 1e6}) {
    for (const double youngs_modulus : {0.0, 1.9e11, 1e13}) {
      for (const double radius : {0.0, 0.34e-3, 5e-3}) {
        for (const double length : {0.0, 1e-9, 1e-6, 1e-3, 0.02, 1.1, 1e3}) {
          StringParameters string = string_at();
          string.p_WB[0] = length;
          string.tension = tension;
          string.youngs_modulus = youngs_modulus;
          string.radius = radius;
          string.friction_coefficient = 0.4;
          RenderingScene scene = scene_of({string});
          scene.instrument.friction = length > 0.5;
          scene.instrument.lateral_force = length < 0.5;
          CAPTURE(tension);
          CAPTURE(youngs_modulus);
          CAPTURE(radius);
          CAPTURE(length);
          const double x = 0.37 * length;
          ToolRun run(scene, pose_at({x, 0.03, 0.2e-3}));
          check_way(run, playing(x, rest_distance(radius)), 12);
        }
      }
    }
  }
}

TEST_CASE("a slack string without stiffness gives no force and does not stop the finger") {
  StringParameters string = string_at();
  string.tension = 0.0;
  string.youngs_modulus = 0.0;
  const RenderingScene scene = scene_of({string});
  ToolRun run(scene, pose_at({0.5, 0.02, 0.0}));
  const double s = rest_distance(string.radius);
  glide(run, {0.5, s + 1e-3, 0.0}, {0.5, s - 5e-3, 0.0}, 100,
        [&](const Vector3& /*p_WH*/) { CHECK(rendered(run).F_H_W.f.norm() < 1e-6); });
  CHECK((run.state.X_WG.p - Vector3(0.5, s - 5e-3, 0.0)).norm() < 30e-6);
}

TEST_CASE("any coupling and contact stiffness gives a finite force and no penetration") {
  for (const double kt : {1.0, 1e3, 1e6}) {
    for (const double contact_stiffness : {1e-3, 1.0, 1e3, 1e9}) {
      StringParameters string = string_at();
      string.contact_stiffness = contact_stiffness;
      const RenderingScene scene = scene_of({string});
      ToolRun run(scene, pose_at({0.5, 0.03, 0.2e-3}));
      run.stiffness.kt = kt;
      CAPTURE(kt);
      CAPTURE(contact_stiffness);
      check_way(run, playing(0.5, rest_distance(string.radius)), 20);
    }
  }
}

TEST_CASE("sixty spheres on one string that yields give the force of one") {
  const std::vector<Sphere> sixty(60, Sphere{{0, 0, 0}, kTipRadius});
  const RenderingScene one = scene_of({string_at()});
  const RenderingScene many = scene_of({string_at()}, sixty);
  ToolRun run_one(one, pose_at({0.3, 0.02, 0.0}));
  ToolRun run_many(many, pose_at({0.3, 0.02, 0.0}));
  double largest = 0.0;
  for (int tick = 0; tick < 200; ++tick) {
    const Pose X_WH = pose_at({0.3 + 1e-4 * tick, 0.008 - 3e-5 * tick, 3e-4 * std::sin(0.1 * tick)},
                              {0.001 * tick, 0, 0});
    const Wrench a = run_one.tick(X_WH).F_H_W;
    const Wrench b = run_many.tick(X_WH).F_H_W;
    CHECK((a.f - b.f).norm() < 1e-9);
    CHECK((deflection_of(run_one, 0) - deflection_of(run_many, 0)).norm() < 1e-9);
    CHECK(run_many.result.qp_iterations <= run_many.result.sub_steps * 3 * 120);
    largest = std::max(largest, a.f.norm());
  }
  CHECK(largest > 0.2);
}

TEST_CASE("jumps of the hand across a bent string enter nothing") {
  for (const double jump : {0.01, 0.2, 10.0, 1e6}) {
    for (const double friction : {0.0, 0.6}) {
      StringParameters string = string_at();
      string.friction_coefficient = friction;
      RenderingScene scene = scene_of({string, string_at(-4e-3, 6e-3)});
      scene.instrument.friction = friction > 0.0;
      ToolRun run(scene, pose_at({0.5, 0.02, 0.0}));
      const double s = rest_distance(string.radius);
      const Vector3 pressed(0.5, s - 3e-3, 0.3e-3);
      for (const Vector3& way : {Vector3(0, -1, 0), Vector3(0, -1, 0.7), Vector3(1, 0, 0),
                                 Vector3(-1, 0.001, 0), Vector3(0, 0, 1), Vector3(0, 1, 0)}) {
        CAPTURE(jump);
        CAPTURE(friction);
        CAPTURE(way);
        glide(run, {0.5, s + 0.05, 0.3e-3}, {0.5, s + 1e-3, 0.3e-3}, 100);
        check_way(run, {{0.5, s + 1e-3, 0.3e-3}, pressed}, 30);
        for (int tick = 0; tick < 6; ++tick) {
          const Vector3 p_WH = tick % 2 == 0 ? Vector3(pressed + jump * way) : pressed;
          CHECK(run.tick_along(pose_at(p_WH)) >= -kAllowedDepth);
          REQUIRE(finite(run));
          CHECK(run.result.F_H_W.f.norm() <= run.stiffness.kt * jump * 2.0 + 10.0);
        }
      }
    }
  }
}

TEST_CASE("a pose that is no number while a string is bent holds, then silences the force") {
  const RenderingScene owner = scene_of({string_at()});
  ToolScene scene{owner.tool(), owner.obstacles(), {}, {}, {}, owner.strings};
  ToolState state;
  RenderedTool tick;
  const auto problem = std::make_unique<ContactProblem>();
  HandPose sample;
  GuardedHand hand;
  PoseVerdict verdict = PoseVerdict::kGood;
  const auto render = [&](double y) {
    sample.t_ns += 1'000'000;
    sample.p_WH = {0.5, y, 0.0};
    verdict = guarded_render(sample, hand, {scene, state, *problem}, tick);
  };
  for (int i = 0; i < 60; ++i) render(0.008 - 1e-4 * i);
  const double bad[] = {std::numeric_limits<double>::quiet_NaN(),
                        std::numeric_limits<double>::infinity(), 1e308};
  for (const double y : bad) {
    for (int i = 0; i < 3; ++i) render(0.002);
    const double pressed = tick.F_H_W.f.norm();
    CHECK(pressed > 0.2);
    for (int i = 0; i < 2; ++i) {
      render(y);
      CHECK(tick.F_H_W.f.norm() == within(pressed, 1e-3));
    }
    render(y);
    CHECK(verdict == PoseVerdict::kFault);
    CHECK(tick.F_H_W.f.norm() == 0.0);
    CHECK(state.contact.touched.size() == 1);
    CHECK(state.contact.touched[0].bend.u_W.allFinite());
    hand.clear();
    for (int i = 0; i < 3; ++i) render(0.002);
    CHECK(tick.F_H_W.f.norm() == within(pressed, 1e-3));
  }
}

TEST_CASE("a scene edited onto a tool that bends a string pushes it out slowly and gently") {
  RenderingScene owner = scene_of({string_at(), string_at(-0.05, 0.0)});
  ToolScene scene{owner.tool(), owner.obstacles(), {}, {}, {}, owner.strings};
  ToolState state;
  RenderedTool tick;
  const auto problem = std::make_unique<ContactProblem>();
  HandPose sample;
  const auto render = [&](double y) {
    sample.t_ns += 1'000'000;
    sample.p_WH = {0.5, y, 0.3e-3};
    render_tool(scene, sample, state, *problem, tick);
  };
  for (const double onto : {0.004, 0.003, 0.0, -0.002}) {
    for (int i = 0; i < 60; ++i) render(0.02 - 3e-4 * i);
    for (int i = 0; i < 60; ++i) render(0.002);
    REQUIRE(state.contact.touched.size() == 1);
    const Capsule before = owner.capsules_W[1];
    owner.capsules_W[1].p_A.y() = owner.capsules_W[1].p_B.y() = onto;
    int recovering = 0;
    Vector3 p_before = tick.X_WG.p;
    for (int i = 0; i < 300; ++i) {
      render(0.002);
      REQUIRE(tick.F_H_W.f.allFinite());
      REQUIRE(tick.X_WG.p.allFinite());
      if (tick.contact.status == ContactStatus::kRecovering) {
        ++recovering;
        CHECK((tick.X_WG.p - p_before).norm() <= 2e-3 + 1e-9);
        CHECK(tick.F_H_W.f.norm() <= kRecoveryForce + 1e-9);
      }
      p_before = tick.X_WG.p;
    }
    CAPTURE(onto);
    CHECK(recovering >= 1);
    CHECK(recovering < 20);
    CHECK(owner.true_path_gap(state.contact, state.contact) >= -kAllowedDepth);
    owner.capsules_W[1] = before;
    for (int i = 0; i < 100; ++i) render(0.002 + 3e-4 * i);
  }
}

TEST_CASE("one linearisation per tick is slower to follow and enters no string either") {
  const std::int64_t strokes = scaled(20'000);
  long double deepest = 1.0L;
  for (std::int64_t i = 0; i < strokes; ++i) {
    const Stroke stroke = make_string_stroke(static_cast<std::uint64_t>(i) + 500'000);
    ToolRun run(stroke.scene, stroke.X_WH.front());
    run.options.sub_steps = 1;
    for (const Pose& X_WH : stroke.X_WH) {
      deepest = std::min(deepest, run.tick_along(X_WH));
      REQUIRE(finite(run));
    }
  }
  MESSAGE("deepest point of " << strokes << " committed paths: " << static_cast<double>(deepest)
                              << " m");
  CHECK(deepest >= -kAllowedDepth);
}

}  // namespace hapticd::test
