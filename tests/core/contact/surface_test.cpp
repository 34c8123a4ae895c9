// The force of a tick is that of the exact surface, whatever the solver keeps off it: against
// closed forms over random clouds, at rest and in motion, before touch, and with any skin.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/math/rotation.h"
#include "tests/core/contact/string_scenes.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kLineRadius = 0.5e-3;
constexpr double kTouch = kTipRadius + kLineRadius;
constexpr int kRestTicks = 40;

/// Seeds of the random clouds: a fixed one, and one that no run has seen before.
std::vector<std::uint64_t> seeds() { return {1, std::random_device{}()}; }

Capsule line_along_x(double y, double z) {
  return {Vector3(-0.5, y, z), Vector3(0.5, y, z), kLineRadius};
}

/// A fingertip at the origin of G, and lines along x.
RenderingScene lines_at(const std::vector<Eigen::Vector2d>& places_yz) {
  RenderingScene scene = scene_of({});
  for (const auto& yz : places_yz) {
    scene.capsules_W.push_back(line_along_x(yz.x(), yz.y()));
  }
  return scene;
}

/// What a rigid ball of the fingertip's reach about the axis x gives: kt times the overlap along
/// the line of centres.
Vector3 force_of_line(const Vector3& p_WH, double kt) {
  const double distance = std::hypot(p_WH.y(), p_WH.z());
  return kt * std::max(0.0, kTouch - distance) / distance * Vector3(0.0, p_WH.y(), p_WH.z());
}

/// Of a tool that touches two lines at (0, +-half) from above: it rests in the groove.
Vector3 force_of_groove(const Vector3& p_WH, double half, double kt) {
  return kt * Vector3(0.0, std::sqrt(kTouch * kTouch - half * half) - p_WH.y(), -p_WH.z());
}

}  // namespace

TEST_CASE("at rest a finger on a line is pushed by kt times its overlap, and stands on the line") {
  const RenderingScene scene = lines_at({{0.0, 0.0}});
  for (const std::uint64_t seed : seeds()) {
    CAPTURE(seed);
    SplitMix64 random(seed);
    for (std::int64_t k = scaled(200); k > 0; --k) {
      ToolRun run(scene, pose_at({0.0, 0.02, 0.0}));
      run.stiffness.kt = std::pow(10.0, random.uniform(1.0, 5.0));
      const double angle = random.uniform(0.3, 2.8);
      const double overlap = random.uniform(-5e-6, 4e-3);
      const Vector3 p_WH = (kTouch - overlap) * Vector3(0.0, std::sin(angle), std::cos(angle));
      glide(run, {0.0, 0.02, p_WH.z()}, p_WH, 40);
      run.hold(pose_at(p_WH), kRestTicks);
      const Vector3 truth = force_of_line(p_WH, run.stiffness.kt);
      CHECK((run.result.F_H_W.f - truth).norm() <=
            1e-6 * run.stiffness.kt * 1e-3 + 1e-9 * truth.norm());
      CHECK((run.state.X_WG.p - p_WH).norm() * run.stiffness.kt ==
            doctest::Approx(truth.norm()).epsilon(1e-6).scale(1e-3 * run.stiffness.kt));
      CHECK(scene.true_gap(run.state.X_WG) >= 0.0L);
    }
  }
}

TEST_CASE("at rest in the groove of two lines both bear what their surfaces bear") {
  for (const std::uint64_t seed : seeds()) {
    CAPTURE(seed);
    SplitMix64 random(seed);
    for (std::int64_t k = scaled(100); k > 0; --k) {
      const double half = random.uniform(0.2, 0.95) * kTouch;
      const RenderingScene scene = lines_at({{0.0, half}, {0.0, -half}});
      ToolRun run(scene, pose_at({0.0, 0.02, 0.0}));
      const double height = std::sqrt(kTouch * kTouch - half * half);
      const Vector3 p_WH(0.0, height - random.uniform(1e-3, 4e-3), random.uniform(-1e-4, 1e-4));
      glide(run, {0.0, 0.02, 0.0}, p_WH, 40);
      run.hold(pose_at(p_WH), kRestTicks);
      CHECK((run.result.F_H_W.f - force_of_groove(p_WH, half, run.stiffness.kt)).norm() <= 1e-4);
    }
  }
}

TEST_CASE(
    "a finger that sinks and slides feels the exact surface at every tick, and none of it before "
    "touch") {
  const RenderingScene scene = lines_at({{0.0, 0.0}});
  for (const std::uint64_t seed : seeds()) {
    CAPTURE(seed);
    SplitMix64 random(seed);
    for (std::int64_t k = scaled(100); k > 0; --k) {
      ToolRun run(scene, pose_at({0.0, 0.02, 0.0}));
      const double speed = std::pow(10.0, random.uniform(-4.0, -0.7));
      Vector3 p_WH(0.0, kTouch + random.uniform(0.0, 40e-6), random.uniform(-1e-4, 1e-4));
      run.tick(pose_at(p_WH));
      double error = 0.0;
      double before_touch = 0.0;
      for (int tick = 0; tick < 200 && p_WH.norm() > 1e-3; ++tick) {
        const Vector3 step = 1e-3 * speed * to_vector(random.direction());
        p_WH += Vector3(0.0, -std::abs(step.y()), step.z());
        run.tick(pose_at(p_WH));
        const Vector3 truth = force_of_line(p_WH, run.stiffness.kt);
        error = std::max(error, (run.result.F_H_W.f - truth).norm());
        if (truth.norm() == 0.0) before_touch = std::max(before_touch, run.result.F_H_W.f.norm());
      }
      CHECK(error <= 5e-3);
      CHECK(before_touch == 0.0);
    }
  }
}

TEST_CASE("a skin of 0 is as good as one of a nanometre: a lever turns, a string yields") {
  for (const double skin : {0.0, 1e-12, 1e-9, 20e-6, 1e-3}) {
    CAPTURE(skin);
    RenderingScene lever = scene_of({}, {{Vector3(0.0, 0.0, 0.02), kTipRadius}});
    lever.capsules_W = {{Vector3(-0.55, 0.0, 0.02), Vector3(0.55, 0.0, 0.02), 0.34e-3}};
    ToolRun turned(lever, pose_at({0.0, 0.012, 0.0}));
    turned.options.skin = skin;
    turned.stiffness.length = 0.01;
    glide(turned, {0.0, 0.012, 0.0}, {0.0, 0.002, 0.0}, 50);
    turned.hold(pose_at({0.0, 0.002, 0.0}), 60);
    // 3.34 mm are shared between a shift and a turn of 20 mm, which is 1 + 20^2 / 10^2 times
    // softer.
    CHECK(log_rotation(turned.state.X_WG.q).x() == within(-0.1336, 0.03));

    const RenderingScene string = scene_of({string_at()});
    ToolRun bent(string, pose_at({0.4, 0.02, 0.0}));
    bent.options.skin = skin;
    const double s = rest_distance(string.capsules_W[0].r);
    glide(bent, {0.4, s + 1e-3, 0.0}, {0.4, s - 3e-3, 0.0}, 50);
    bent.hold(pose_at({0.4, s - 3e-3, 0.0}), 60);
    CHECK(deflection_of(bent, 0).norm() > 2.5e-3);
  }
}

TEST_CASE("a margin hardly above the skin still lets the tool come down, and holds it") {
  const RenderingScene scene = lines_at({{0.0, 0.0}});
  ToolRun run(scene, pose_at({0.0, 0.02, 0.0}));
  run.options.skin = 1e-3;
  run.options.margin = 1.001e-3;
  glide(run, {0.0, 0.02, 0.0}, {0.0, kTouch - 2e-3, 0.0}, 100);
  run.hold(pose_at({0.0, kTouch - 2e-3, 0.0}), 60);
  CHECK(run.result.F_H_W.f.y() == within(2e-3 * run.stiffness.kt, 1e-3));
}

}  // namespace hapticd::test
