// The table of extremes where shape alone decides: strings of any direction, radius and length
// pressed at the middle, the seam and the end, and turns by almost exactly half a circle. Truth:
// the nearest point of the fattened capsule, the exhaustive oracle.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"
#include "core/math/rotation.h"
#include "tests/core/contact/rendering_fixture.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr double kTip = 5e-3;
constexpr double kString = 0.34e-3;
const std::vector<Sphere> kTool{{{0, 0, 0}, kTip}};

/// Presses the tip from `start` to `p_WH` and returns where it comes to rest.
Vector3 rest(const Capsule& capsule, const Vector3& start, const Vector3& p_WH) {
  RenderingScene scene(kTool);
  scene.capsules_W = {capsule};
  ToolRun run(scene, pose_at(start));
  run.options.stop_tolerance = 1e-10;
  run.hold(pose_at(p_WH), 60);
  CHECK(run.result.F_H_W.f.allFinite());
  CHECK(scene.true_gap(run.state.X_WG) >= -1e-9L);
  return run.state.X_WG.p;
}

}  // namespace

TEST_CASE(
    "pressed anywhere on a string of any direction, radius and length the tip rests at the nearest "
    "point outside it") {
  SplitMix64 random(1);
  for (std::int64_t trial = 0; trial < scaled(1'000); ++trial) {
    static constexpr double kRadii[] = {0.0, 1e-9, kString, 1.0};
    const double R = kRadii[random.below(4)];
    const double L = std::pow(10.0, random.uniform(-6.0, 4.0));
    const Directions n = random_directions(random);
    // In the middle, at the seam of cylinder and cap to the last bit, or over the cap.
    const double turn = trial % 3 == 2 ? random.uniform(0.0, 0.5 * kPi) : 0.0;
    const Vector3 outwards = sin_cos(turn).cos * n.across + sin_cos(turn).sin * n.along;
    const double s = kTip + R;
    const double depth = random.uniform(0.1, 0.9) * (kTip + std::min(R, kTip));
    // The point of the axis that carries the contact is W's origin.
    const double beyond = trial % 3 == 0 ? 0.5 * L : 0.0;
    const Capsule capsule{(beyond - L) * n.along, beyond * n.along, R};
    CAPTURE(R);
    CAPTURE(L);
    CAPTURE(turn);
    const Vector3 p_WG = rest(capsule, (s + 2e-3) * outwards, (s - depth) * outwards);
    CHECK((p_WG - s * outwards).norm() <= 1e-6 * s);
  }
}

TEST_CASE("a tip dragged over the end of a string in any direction feels no step of force") {
  SplitMix64 random(2);
  for (std::int64_t trial = 0; trial < scaled(100); ++trial) {
    const Directions n = random_directions(random);
    RenderingScene scene(kTool);
    scene.capsules_W = {{-0.6 * n.along, {0, 0, 0}, kString}};
    const double s = kTip + kString;
    // Out over the end, and a little to the side.
    const Vector3 side = n.along.cross(n.across);
    const Vector3 way = (n.along + random.uniform(-0.3, 0.3) * side).normalized();
    const double speed = random.uniform(0.05, 0.3);
    const Vector3 start = (s - random.uniform(0.5e-3, 3e-3)) * n.across - 8e-3 * way;
    ToolRun run(scene, pose_at(start + 8e-3 * n.across));
    run.hold(pose_at(start), 40);
    Vector3 before = run.result.F_H_W.f;
    CHECK(before.norm() > 0.01);
    const int ticks = static_cast<int>(0.03 / speed * 1e3);
    for (int tick = 1; tick <= ticks; ++tick) {
      run.tick(pose_at(start + speed * 1e-3 * tick * way));
      const Vector3 now = run.result.F_H_W.f;
      REQUIRE((now - before).norm() <= 1.5 * run.stiffness.kt * speed * 1e-3);
      before = now;
    }
    CHECK(before.norm() == 0.0);
  }
}

TEST_CASE("turned in one tick by pi, or a millionth less or more, no constraint is broken") {
  RenderingScene scene({{{0.04, 0, 0}, kTip}, {{-0.03, 0, 0.01}, kTip}, {{0, 0, 0}, kTip}});
  scene.capsules_W = {{{-0.5, -0.012, 0.02}, {0.5, -0.012, 0.02}, kString},
                      {{0.02, -0.5, 0.02}, {0.02, 0.5, 0.02}, kString}};
  SplitMix64 random(3);
  for (std::int64_t trial = 0; trial < scaled(200); ++trial) {
    const Vector3 axis = to_vector(random.direction());
    for (const double angle : {kPi - 1e-6, kPi, kPi + 1e-6, -kPi, 1e-6, 2.0 * kPi - 1e-6}) {
      CAPTURE(angle);
      ToolRun run(scene, pose_at({0, 0, 0}));
      for (int tick = 0; tick < 40; ++tick) {
        run.tick(pose_at({0, 0, 0}, axis * angle));
        REQUIRE(run.result.F_H_W.t.allFinite());
        REQUIRE(scene.true_gap(run.state.X_WG) >= -1e-7L);
        REQUIRE(run.result.F_H_W.t.norm() <= run.stiffness.kr() * 2.0 * kPi);
      }
    }
  }
}

}  // namespace hapticd::test
