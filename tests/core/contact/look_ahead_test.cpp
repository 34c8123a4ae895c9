// How far the query looks: as far as hand or tool go, never farther than the margin. Truth: what is
// farther bears no force, so that a tool that looks at all of it feels the same.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/core/contact/rendering_fixture.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

constexpr double kRadius = 5e-3;
constexpr double kMargin = 5e-3;

/// A finger of three spheres over a bed of small ones, 3 mm apart.
RenderingScene bed() {
  RenderingScene scene({{{0, 0, 0}, kRadius}, {{0, 0, 8e-3}, kRadius}, {{0, 0, 16e-3}, kRadius}});
  std::vector<Sphere> bumps;
  for (int i = -10; i <= 10; ++i) {
    for (int k = -10; k <= 20; ++k) bumps.push_back({{3e-3 * i, 0, 3e-3 * k}, 2.5e-3});
  }
  scene.add_body(bumps, {});
  return scene;
}

double looked(const ToolRun& run) { return run.problem->candidates().contacts().covered_margin; }

}  // namespace

TEST_CASE(
    "a tool at rest looks an eighth of the margin far, one that moves at least as far as it goes") {
  const RenderingScene scene = bed();
  ToolRun run(scene, pose_at({0, 0.01, 0}));
  run.options.margin = kMargin;
  run.hold(pose_at({0, 6e-3, 0}), 500);
  REQUIRE(run.result.F_H_W.f.norm() > 0.5);
  CHECK(looked(run) == kMargin / 8);
  const std::size_t at_rest = run.problem->candidates().contacts().contacts.size();
  run.tick(pose_at({1e-3, 6e-3, 0}));
  CHECK(looked(run) >= 1e-3);
  CHECK(run.problem->candidates().contacts().contacts.size() > at_rest);
  run.tick(pose_at({10e-3, 6e-3, 0}));
  CHECK(looked(run) == kMargin);
}

TEST_CASE("a tool that looks no farther than it goes feels what one feels that looks at all") {
  const RenderingScene scene = bed();
  SplitMix64 random(7);
  for (int session = 0; session < 20; ++session) {
    const double fast = random.uniform(1.0, 40.0);
    const double deep = random.uniform(0.5e-3, 4e-3);
    const double phase = random.uniform(0.0, 6.0);
    const auto pose = [&](int tick) {
      const double t = 1e-3 * tick;
      return pose_at({0.015 * std::sin(fast * t + phase), 7.2e-3 - deep * std::min(1.0, 10.0 * t),
                      0.01 * std::sin(0.7 * fast * t)},
                     {0.1 * std::sin(3 * t), 0.2 * std::sin(fast * t), 0.0});
    };
    ToolRun run(scene, pose(0));
    ToolRun all(scene, pose(0));
    run.options.margin = all.options.margin = kMargin;
    run.options.sub_steps = all.options.sub_steps = 100;
    double largest = 0.0;
    double squares = 0.0;
    double sum = 0.0;
    for (int tick = 1; tick < 500; ++tick) {
      run.tick(pose(tick));
      all.state.travel = kMargin;
      all.tick(pose(tick));
      REQUIRE(looked(all) == kMargin);
      const double apart = (run.result.F_H_W.f - all.result.F_H_W.f).norm();
      largest = std::max(largest, apart);
      squares += apart * apart;
      sum += all.result.F_H_W.f.squaredNorm();
      if (tick % 10 == 0) REQUIRE(scene.true_gap(run.state.X_WG) > -1e-9L);
    }
    CAPTURE(largest);
    CHECK(std::sqrt(squares / sum) < 1e-3);
  }
}

}  // namespace hapticd::test
