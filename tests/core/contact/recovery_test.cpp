// Starts that penetrate: out along the deepest normals at a bounded speed, finite, flagged, force
// ramped in.
#include "core/contact/recovery.h"

#include <doctest/doctest.h>

#include <cmath>

#include "core/simulation/tool_renderer.h"
#include "tests/core/contact/rendering_fixture.h"
#include "tests/support/guarded_step.h"
#include "tests/support/random.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kTip = 5e-3;
constexpr double kString = 0.34e-3;
const std::vector<Sphere> kTool{{{0, 0, 0}, kTip}};

std::vector<Sphere> slab(int n, double spacing, double r) {
  std::vector<Sphere> spheres;
  spheres.reserve(static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
  const int half = n / 2;
  for (int i = 0; i < n * n; ++i) {
    spheres.push_back(
        {{spacing * (i % n - half), 0, spacing * (static_cast<int>(i / n) - half)}, r});
  }
  return spheres;
}

}  // namespace

TEST_CASE(
    "a tool whose centre starts on a string's axis is out within three sub-steps, always by the "
    "same way") {
  RenderingScene scene(kTool);
  scene.capsules_W = {{{-0.5, 0, 0}, {0.5, 0, 0}, kString}};
  Vector3 first_way;
  for (int repeat = 0; repeat < 3; ++repeat) {
    ToolRun run(scene, pose_at({0.1, 0, 0}));
    for (int tick = 0; tick < 3; ++tick) {
      run.tick(pose_at({0.1, 0, 0}));
      CHECK(run.result.status == ContactStatus::kRecovering);
    }
    CHECK(scene.true_gap(run.state.X_WG) >= 0.0L);
    if (repeat == 0) first_way = run.state.X_WG.p;
    CHECK(run.state.X_WG.p == first_way);
    run.tick(pose_at({0.1, 0, 0}));
    CHECK(run.result.status != ContactStatus::kRecovering);
  }
}

TEST_CASE(
    "a scene edited onto the tool pushes it out no faster than two millimetres per millisecond") {
  RenderingScene scene(kTool);
  scene.add_body(slab(9, 4e-3, 12e-3), pose_at({0, 0, 0}));
  ToolRun run(scene, pose_at({0.001, 0.004, -0.002}));
  long double depth = scene.true_gap(run.state.X_WG);
  CHECK(depth < -5e-3L);
  int ticks = 0;
  while (depth < 0.0L && ticks < 50) {
    const Vector3 before = run.state.X_WG.p;
    run.tick(pose_at({0.001, 0.004, -0.002}));
    CHECK((run.state.X_WG.p - before).norm() <= 2e-3 * (1 + 1e-12));
    const long double now = scene.true_gap(run.state.X_WG);
    CHECK(now > depth);
    depth = now;
    ++ticks;
  }
  CHECK(depth >= 0.0L);
  CHECK(ticks <= 10);
}

TEST_CASE("pushed out of a body the tool neither enters nor passes what it was clear of") {
  const double clearance = 0.5e-3;
  RenderingScene scene(kTool);
  scene.add_body(slab(9, 4e-3, 12e-3), pose_at({0, 0, 0}));
  // Strings above it, so near to each other that it cannot leave between them.
  RenderingScene strings(kTool);
  for (int k = -3; k <= 3; ++k) {
    const double z = 4e-3 * k;
    const double y = 4e-3 + kTip + kString + clearance;
    strings.capsules_W.push_back({{-0.5, y, z}, {0.5, y, z}, kString});
  }
  scene.capsules_W = strings.capsules_W;
  SplitMix64 random(1);
  for (int i = 0; i < 20; ++i) {
    const Pose X_WH = pose_at(
        {random.uniform(-2e-3, 2e-3), random.uniform(2e-3, 4e-3), random.uniform(-6e-3, 6e-3)});
    ToolRun run(scene, X_WH);
    REQUIRE(scene.true_gap(X_WH) < -5e-3L);
    for (int tick = 0; tick < 300; ++tick) {
      const Pose X_before = run.state.X_WG;
      run.tick(X_WH);
      REQUIRE(strings.true_path_gap(X_before, run.state.X_WG) >= 0.0L);
    }
    CHECK(run.state.X_WG.p.y() > X_WH.p.y());
  }
}

TEST_CASE(
    "wedged between obstacles that leave no room the tool stays finite, flagged, and never moves "
    "deeper") {
  RenderingScene scene(kTool);
  for (const Vector3& p : {Vector3(0, 6e-3, 0), Vector3(0, -6e-3, 0), Vector3(6e-3, 0, 0),
                           Vector3(-6e-3, 0, 0), Vector3(0, 0, 6e-3), Vector3(0, 0, -6e-3)}) {
    scene.add_body({{{0, 0, 0}, 4e-3}}, pose_at(p));
  }
  ToolRun run(scene, pose_at({1e-4, 0, 0}));
  long double depth = scene.true_gap(run.state.X_WG);
  for (int tick = 0; tick < 100; ++tick) {
    run.tick(pose_at({0.01, 0, 0}));
    CHECK(run.result.status == ContactStatus::kRecovering);
    CHECK(run.result.F_H_W.f.allFinite());
    const long double now = scene.true_gap(run.state.X_WG);
    CHECK(now >= depth);
    depth = now;
  }
}

TEST_CASE(
    "after a penetrated start the force is clamped to two newtons and grows by no more than 50 "
    "N/s") {
  RenderingScene scene(kTool);
  scene.capsules_W = {{{-0.5, 0, 0}, {0.5, 0, 0}, kString}};
  const ToolScene tool_scene{scene.tool(), scene.obstacles(), {}, {}, {}};
  ToolState state;
  auto problem = std::make_unique<ContactProblem>();
  RenderedTool tick;
  double before = 0.0;
  for (int i = 0; i < 400; ++i) {
    render_tool(tool_scene, {std::int64_t{1'000'000} * (i + 1), {0, 1e-3, 0}, {1, 0, 0, 0}}, state,
                *problem, tick);
    const double force = tick.F_H_W.f.norm();
    CHECK(force <= before + kRecoveryForceRate * 1e-3 + 1e-12);
    if (tick.contact.status == ContactStatus::kRecovering) CHECK(force <= kRecoveryForce);
    before = force;
  }
  CHECK(tick.F_H_W.f.norm() == within(1000.0 * (kTip + kString - 1e-3), 0.01));
}

}  // namespace hapticd::test
