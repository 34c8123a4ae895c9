// The table of extremes, geometry and motion: one row, one test. Truth: closed forms and the
// exhaustive oracle.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "core/math/elementary.h"
#include "core/math/rotation.h"
#include "core/simulation/tool_renderer.h"
#include "tests/core/contact/rendering_fixture.h"
#include "tests/support/guarded_step.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"
#include "tests/truth/exact_statics.h"

namespace hapticd::test {
namespace {

constexpr double kTip = 5e-3;
constexpr double kString = 0.34e-3;
/// Of the lines that are nearly one, m: what it adds to a force is below their difference.
constexpr double kThinSkin = 1e-9;
const std::vector<Sphere> kTool{{{0, 0, 0}, kTip}};

RenderingScene string_scene() {
  RenderingScene scene(kTool);
  scene.capsules_W = {{{-0.55, 0, 0}, {0.55, 0, 0}, kString}};
  return scene;
}

/// A tool with levers in all directions.
std::vector<Sphere> jack() {
  return {{{0.04, 0, 0}, kTip},
          {{-0.04, 0, 0}, kTip},
          {{0, 0, 0.03}, kTip},
          {{0, 0, -0.03}, kTip},
          {{0, -0.01, 0}, kTip}};
}

}  // namespace

TEST_CASE(
    "sliding over the end of a string changes the force by no more than the motion explains") {
  const RenderingScene scene = string_scene();
  const double speed = 0.2;
  const double depth = 3e-3;
  for (const double offset : {0.0, 1e-3}) {
    ToolRun run(scene, pose_at({0.50, kTip + kString + 1e-3, offset}));
    run.hold(pose_at({0.50, kTip + kString - depth, offset}), 30);
    Vector3 before = run.result.F_H_W.f;
    for (int tick = 1; tick <= 400; ++tick) {
      run.tick(pose_at({0.50 + speed * 1e-3 * tick, kTip + kString - depth, offset}));
      const Vector3 now = run.result.F_H_W.f;
      CAPTURE(tick);
      CHECK((now - before).norm() <= 1.5 * run.stiffness.kt * speed * 1e-3);
      before = now;
    }
    CHECK(before.norm() == 0.0);
  }
}

TEST_CASE(
    "a tip pressed at any string radius, length or ratio comes to rest at the nearest point of the "
    "true capsule") {
  struct Case {
    double r, length;
  };
  for (const Case c :
       {Case{0.0, 1.1}, Case{1e-9, 1.1}, Case{1.0, 1.1}, Case{1e-3, 1.0}, Case{1e-3, 1e4},
        Case{1e-4, 1e3}, Case{0.34e-3, 1e-6}, Case{0.34e-3, 1e7}, Case{0.34e-3, 0.0}}) {
    CAPTURE(c.r);
    CAPTURE(c.length);
    RenderingScene scene(kTool);
    scene.capsules_W = {{{-0.5 * c.length, 0, 0}, {0.5 * c.length, 0, 0}, c.r}};
    const double s = kTip + c.r;
    const Vector3 p_WH(0, s - 1e-3, 0.2e-3);
    ToolRun run(scene, pose_at({0, s + 2e-3, 0.2e-3}));
    run.hold(pose_at(p_WH), 60);
    // Nearest point to H outside the fattened capsule; H is above the middle, where the capsule is
    // a cylinder or a sphere.
    const Vector3 truth = p_WH.normalized() * s;
    CHECK((run.state.X_WG.p - truth).norm() < 1e-6 * s + 1e-6 * kTip);
  }
}

TEST_CASE(
    "with the ratio of rotation to translation fixed the shape of the answer does not depend on "
    "the stiffness") {
  RenderingScene scene(jack());
  std::vector<Sphere> plate;
  plate.reserve(400);
  for (int i = 0; i < 400; ++i)
    plate.push_back({{0.006 * (i % 20 - 10), 0, 0.006 * (static_cast<int>(i / 20) - 10)}, 0.01});
  scene.add_body(plate, pose_at({0, -0.01, 0}));
  Wrench unit;
  for (const double kt : {1.0, 1e-3, 1e3, 1e6, 1e9}) {
    CAPTURE(kt);
    ToolRun run(scene, pose_at({0.001, 0.03, 0.002}));
    run.stiffness.kt = kt;
    for (int tick = 0; tick < 60; ++tick)
      run.tick(pose_at({0.001, 0.03 - 0.0006 * tick, 0.002}, {0.1, 0.05, -0.08}));
    const Wrench per_kt{run.result.F_H_W.f / kt, run.result.F_H_W.t / kt};
    if (kt == 1.0) unit = per_kt;
    CHECK((per_kt.f - unit.f).norm() < 1e-9 * unit.f.norm());
    CHECK((per_kt.t - unit.t).norm() < 1e-9 * unit.t.norm());
    CHECK(unit.f.norm() > 1e-3);
  }
}

TEST_CASE("sixty spheres on one string give the force of one") {
  std::vector<Sphere> sixty(60, Sphere{{0, 0, 0}, kTip});
  const RenderingScene one = string_scene();
  RenderingScene many(sixty);
  many.capsules_W = one.capsules_W;
  ToolRun run_one(one, pose_at({0, 0.02, 0}));
  ToolRun run_many(many, pose_at({0, 0.02, 0}));
  for (int tick = 0; tick < 200; ++tick) {
    const Pose X_WH =
        pose_at({0, 0.02 - 1e-4 * tick, 1e-3 * std::sin(0.1 * tick)}, {0.001 * tick, 0, 0});
    const Wrench a = run_one.tick(X_WH).F_H_W;
    const Wrench b = run_many.tick(X_WH).F_H_W;
    CHECK((a.f - b.f).norm() < 1e-9);
    CHECK((run_one.state.X_WG.p - run_many.state.X_WG.p).norm() < 1e-9);
    CHECK(run_many.result.qp_iterations <= run_many.result.sub_steps * 3 * 60);
  }
}

TEST_CASE("a tool in a slot exactly as wide as itself stays finite and keeps out of both walls") {
  RenderingScene scene(kTool);
  const double half = kTip + 1e-9;
  scene.add_body({{{0, 0, 1.0}, 1.0}}, pose_at({0, 0, half}));
  scene.add_body({{{0, 0, -1.0}, 1.0}}, pose_at({0, 0, -half}));
  ToolRun run(scene, pose_at({0, 0, 0}));
  for (int tick = 0; tick < 200; ++tick) {
    const Pose X_WH = pose_at({0.01 * std::sin(0.05 * tick), 0.0, 0.003 * std::sin(0.3 * tick)});
    CHECK(run.tick_along(X_WH) > -1e-6L);
    CHECK(run.result.F_H_W.f.allFinite());
  }
}

TEST_CASE("lines that differ by 1e-9 to 1e-6 rad are what the exact statics makes of them") {
  // From 1e-9 rad, where the two are one to rounding, to where the one that is higher bears the
  // tip.
  for (const double angle : {1e-9, 1e-8, 1e-7, 1e-6}) {
    for (const double x : {0.0, 0.2, -0.4}) {
      CAPTURE(angle);
      CAPTURE(x);
      RenderingScene scene = string_scene();
      const double slant = 0.55 * angle;
      scene.capsules_W.push_back({{-0.55, -slant, -slant}, {0.55, slant, slant}, kString});
      ToolRun run(scene, pose_at({x, 0.02, 0}));
      run.options.skin = kThinSkin;
      const Pose X_WH = pose_at({x, kTip - 2e-3, 0.5e-3});
      const Vector3 felt = run.hold(X_WH, 20).F_H_W.f;
      const StaticScene exact{scene.tool_spheres, {}, scene.capsules_W, {}};
      const StaticRest rest = rest_from(exact, X_WH, free_place(exact, pose_at({x, 0.006, 0})));
      CHECK(converged(rest));
      CHECK((felt - rest.F_H_W.f).norm() < 3.0 * run.stiffness.kt * kThinSkin);
      // One line alone gives the same but for how much higher the other one is, and which way it
      // leans.
      const RenderingScene one = string_scene();
      ToolRun alone(one, pose_at({x, 0.02, 0}));
      alone.options.skin = kThinSkin;
      const double higher = 2.0 * std::abs(x) * angle;
      const Vector3 of_one = alone.hold(X_WH, 20).F_H_W.f;
      CHECK((felt - of_one).norm() <
            1e-9 + run.stiffness.kt * higher + 2.0 * angle * of_one.norm());
      CHECK(of_one.norm() > 1.0);
    }
  }
}

TEST_CASE(
    "teleports of 0.2 m, 10 m and a million metres never cross a string and never exceed the "
    "device limit") {
  const RenderingScene scene = string_scene();
  const ToolScene tool_scene{scene.tool(), scene.obstacles(), {}, {}, {}};
  auto problem = std::make_unique<ContactProblem>();
  SplitMix64 random(11);
  for (const double distance : {0.2, 10.0, 1e6}) {
    CAPTURE(distance);
    for (std::int64_t i = 0; i < scaled(2'000); ++i) {
      ToolState state;
      RenderedTool tick;
      const Vector3 from(random.uniform(-0.4, 0.4), 0.02, random.uniform(-0.01, 0.01));
      // Half of them straight at the string.
      const Vector3 way = i % 2 == 0 ? Vector3(0, -1, -from.z() / 0.02).normalized()
                                     : to_vector(random.direction());
      ToolRun judged(scene, pose_at(from));
      for (int k = 0; k < 12; ++k) {
        const Vector3 p = (k / 3) % 2 == 0 ? from : Vector3(from + distance * way);
        render_tool(tool_scene, {std::int64_t{1'000'000} * (k + 1), to_array(p), {1, 0, 0, 0}},
                    state, *problem, tick);
        REQUIRE(tick.F_H_W.f.norm() <= tool_scene.limits.force * (1 + 1e-12));
        REQUIRE(tick.F_H_W.t.norm() <= tool_scene.limits.torque * (1 + 1e-12));
        REQUIRE(judged.tick_along(pose_at(p)) > -1e-7L);
        REQUIRE(judged.state.X_WG.p == state.contact.X_WG.p);
      }
    }
  }
}

TEST_CASE("a flip by 180 degrees turns the tool round without entering the obstacle") {
  RenderingScene scene(jack());
  scene.capsules_W = {{{-0.55, 0, 0}, {0.55, 0, 0}, kString}};
  for (const Vector3& axis :
       {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1), Vector3(0.6, 0, 0.8)}) {
    ToolRun run(scene, pose_at({0, 0.02, 0}));
    for (int tick = 0; tick < 200; ++tick) {
      REQUIRE(run.tick_along(pose_at({0, 0.018, 0}, axis * kPi)) > -1e-7L);
      REQUIRE(run.result.F_H_W.t.allFinite());
    }
  }
}

TEST_CASE("the torque keeps its branch while the hand turns through pi against a blocked tool") {
  // Two walls block any rotation of the bar about y; flat, so that it cannot slip round them.
  RenderingScene scene({{{0.04, 0, 0}, kTip}, {{-0.04, 0, 0}, kTip}});
  constexpr double kWall = 100.0;
  scene.add_body({{{0, 0, 0}, kWall}}, pose_at({0.04, 0, kWall + kTip + 1e-4}));
  scene.add_body({{{0, 0, 0}, kWall}}, pose_at({-0.04, 0, -kWall - kTip - 1e-4}));
  ToolRun run(scene, pose_at({0, 0, 0}));
  double before = 0.0;
  for (int tick = 0; tick <= 3400; ++tick) {
    const double angle = -1e-3 * tick;
    run.tick(pose_at({0, 0, 0}, {0, angle, 0}));
    if (tick > 200) CHECK(run.result.F_H_W.t.y() > 0.9 * before);
    before = run.result.F_H_W.t.y();
  }
  CHECK(before > 2.0);
  for (const double angle : {kPi - 1e-6, kPi, kPi + 1e-6}) {
    CHECK(run.tick_along(pose_at({0, 0, 0}, {0, -angle, 0})) > -1e-7L);
    CHECK(run.result.F_H_W.t.y() == within(kPi, 0.1));
  }
}

TEST_CASE("q and -q are the same pose and give the same force") {
  RenderingScene scene(jack());
  scene.capsules_W = {{{-0.55, 0, 0}, {0.55, 0, 0}, kString}};
  const ToolScene tool_scene{scene.tool(), scene.obstacles(), {}, {}, {}};
  auto problem = std::make_unique<ContactProblem>();
  ToolState plain;
  ToolState mixed;
  RenderedTool a;
  RenderedTool b;
  for (int i = 0; i < 300; ++i) {
    const Quaternion q = exp_rotation({0.01 * i, 0.3 * std::sin(0.02 * i), 0.1});
    const double sign = i % 2 == 0 ? 1.0 : -1.0;
    const Array3 p{0.0, 0.03 - 1e-4 * i, 0.001};
    render_tool(tool_scene, {std::int64_t{1'000'000} * (i + 1), p, {q.w(), q.x(), q.y(), q.z()}},
                plain, *problem, a);
    render_tool(tool_scene,
                {std::int64_t{1'000'000} * (i + 1),
                 p,
                 {sign * q.w(), sign * q.x(), sign * q.y(), sign * q.z()}},
                mixed, *problem, b);
    CHECK((a.F_H_W.f - b.F_H_W.f).norm() < 1e-12);
    CHECK((a.F_H_W.t - b.F_H_W.t).norm() < 1e-12);
    CHECK((a.V_WH.w - b.V_WH.w).norm() < 1e-9);
  }
}

TEST_CASE(
    "a held pose comes to rest: no cycle between two configurations at the edge of the skin") {
  RenderingScene scene(jack());
  scene.capsules_W = {{{-0.55, 0, 0.01}, {0.55, 0, 0.01}, kString},
                      {{-0.55, 0, -0.01}, {0.55, 0, -0.01}, kString}};
  scene.add_body({{{0, 0, 0}, 0.02}}, pose_at({0.03, -0.03, 0}));
  SplitMix64 random(17);
  for (int i = 0; i < 50; ++i) {
    CAPTURE(i);
    ToolRun run(scene, pose_at({0, 0.06, 0}));
    const Vector3 p_WH = Vector3(0, 0.012, 0) + 0.01 * to_vector(random.direction());
    const Pose X_WH = pose_at(p_WH, 0.4 * to_vector(random.direction()));
    run.hold(X_WH, 100);
    const Pose X_rest = run.state.X_WG;
    run.hold(X_WH, 1);
    CHECK((run.state.X_WG.p - X_rest.p).norm() < 1e-6);
    run.hold(X_WH, 100);
    CHECK((run.state.X_WG.p - X_rest.p).norm() < 1e-5);
    CHECK((run.result.status == ContactStatus::kConverged ||
           run.result.status == ContactStatus::kFree));
  }
}

TEST_CASE("a hundred million ticks of contact leave no drift in rotation or force") {
  RenderingScene scene({{{0.03, 0, 0}, kTip}});
  scene.capsules_W = {{{0.03, 0, -0.5}, {0.03, 0, 0.5}, kString}};
  ToolRun run(scene, pose_at({0, 0.02, 0}));
  constexpr int kPeriod = 64;
  std::vector<Pose> cycle;
  cycle.reserve(kPeriod);
  for (int i = 0; i < kPeriod; ++i) {
    const double s = std::sin(2 * kPi * i / kPeriod);
    cycle.push_back(pose_at({1e-4 * s, kTip - 1e-3, 0}, {0.01 * s, 0.02 * s, 0}));
  }
  Wrench first;
  const std::int64_t periods = scaled(100'000'000) / kPeriod + 3;
  for (std::int64_t period = 0; period < periods; ++period) {
    for (const Pose& X_WH : cycle) run.tick(X_WH);
    if (period == 1) first = run.result.F_H_W;
  }
  CHECK(std::abs(run.state.X_WG.q.norm() - 1.0) < 1e-12);
  CHECK((run.result.F_H_W.f - first.f).norm() < 1e-9);
  CHECK(first.f.norm() > 0.1);
}

TEST_CASE("switching between obstacles changes the force by no more than the motion explains") {
  // Five phases: pillar, both, line, both, pillar; outside slips the force may change by 1.1 kt |v|
  // dt, or 0.15 N.
  RenderingScene scene({{{0, 0, 0}, 8e-3}, {{0.012, 0, 0}, 8e-3}, {{-0.012, 0, 0}, 8e-3}});
  scene.capsules_W = {{{-0.3, 0, 0}, {0.3, 0, 0}, 3e-3}};
  std::vector<Sphere> pillar;
  for (double y = -0.1; y <= 0.0; y += 2e-3) pillar.push_back({{0, y, 0}, 8e-3});
  scene.add_body(pillar, pose_at({0.05, 0, 0}));
  const auto pose = [](int tick) {
    const double t = tick * 1e-3;
    return pose_at({0.055 * std::cos(3.0 * t), 0.0145 - 0.0025 * std::min(1.0, 5.0 * t), 1e-4},
                   {0, 0.05 * std::sin(2 * t), 0});
  };
  ToolRun run(scene, pose_at({0.055, 0.03, 1e-4}));
  run.hold(pose(0), 50);
  Vector3 before = run.result.F_H_W.f;
  Pose X_before = pose(0);
  for (int tick = 1; tick < 4000; ++tick) {
    const Pose X_WH = pose(tick);
    run.tick(X_WH);
    const double speed_dt = (X_WH.p - X_before.p).norm();
    CAPTURE(tick);
    CHECK((run.result.F_H_W.f - before).norm() <=
          std::max(0.15, 1.1 * run.stiffness.kt * speed_dt));
    before = run.result.F_H_W.f;
    X_before = X_WH;
  }
}

}  // namespace hapticd::test
