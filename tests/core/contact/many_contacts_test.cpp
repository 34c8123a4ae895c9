// More pairs than the program has rows, and more than the query keeps. Truth: on a flat plate only
// the corners of a flat tool matter, so a tool of its corner spheres alone must feel the same.
#include <doctest/doctest.h>

#include <cmath>

#include "tests/core/contact/rendering_fixture.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kRadius = 5e-3;
constexpr double kHalfWidth = 0.03;
constexpr double kPlate = 1e4;

/// n x n spheres in a plane; n = 2 leaves the corners.
std::vector<Sphere> flat_tool(int n) {
  std::vector<Sphere> spheres;
  spheres.reserve(static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
  for (int i = 0; i < n * n; ++i) {
    const double x = 2.0 * (i % n) / (n - 1) - 1.0;
    const double z = 2.0 * static_cast<int>(i / n) / (n - 1) - 1.0;
    spheres.push_back({{kHalfWidth * x, 0, kHalfWidth * z}, kRadius});
  }
  return spheres;
}

Pose rocking(int tick) {
  const double t = 1e-3 * tick;
  return pose_at({0.002 * std::sin(3 * t), kRadius + 0.001 - 0.003 * std::min(1.0, 5 * t), 0},
                 {0.05 * std::sin(7 * t), 0.1 * t, 0.04 * std::sin(11 * t)});
}

}  // namespace

TEST_CASE(
    "a dense flat tool feels like its four corners, with fewer pairs than rows, with more, and "
    "beyond capacity") {
  RenderingScene corners(flat_tool(2));
  corners.add_body({{{0, 0, 0}, kPlate}}, pose_at({0, -kPlate, 0}));
  for (const int n : {10, 20, 40, 60}) {
    CAPTURE(n);
    RenderingScene dense(flat_tool(n));
    dense.add_body({{{0, 0, 0}, kPlate}}, pose_at({0, -kPlate, 0}));
    ToolRun expected(corners, rocking(0));
    ToolRun run(dense, rocking(0));
    std::size_t most = 0;
    double largest = 0.0;
    for (int tick = 0; tick < 1000; ++tick) {
      expected.tick(rocking(tick));
      run.tick(rocking(tick));
      most = std::max(most, run.problem->candidates().contacts().contacts.size());
      largest = std::max(largest, expected.result.F_H_W.f.norm());
      REQUIRE((run.result.F_H_W.f - expected.result.F_H_W.f).norm() < 0.02);
      REQUIRE((run.result.F_H_W.t - expected.result.F_H_W.t).norm() < 0.02 * kHalfWidth);
      if (tick % 50 == 0) REQUIRE(dense.true_gap(run.state.X_WG) > -1e-9L);
    }
    CHECK(largest > 1.0);
    // Six unknowns hold six rows: thousands of pairs bring in few more.
    CHECK(run.result.rows < 100);
    CHECK(most ==
          std::min(static_cast<std::size_t>(n * n), static_cast<std::size_t>(kMaxCandidates)));
  }
}

TEST_CASE("a pair beyond the nearest 256 stops the step where it touches, in one linearisation") {
  // 300 spheres touch at one end; the tool turns about them until the lone sphere at the other end,
  // 1 mm up, touches too.
  constexpr double kGap = 1e-3;
  std::vector<Sphere> spheres(300, Sphere{{0, 0, kHalfWidth}, kRadius});
  for (std::size_t i = 0; i < spheres.size(); ++i) spheres[i].p.x() = 1e-5 * static_cast<double>(i);
  spheres.push_back({{0, kGap, -kHalfWidth}, kRadius});
  RenderingScene scene(spheres);
  scene.add_body({{{0, 0, 0}, kPlate}}, pose_at({0, -kPlate, 0}));
  ToolRun run(scene, pose_at({0, kRadius + 2e-5, 0}));
  run.options.sub_steps = 1;
  run.tick(pose_at({0, kRadius - 3e-3, 0}));
  const double height = transform(run.state.X_WG, spheres.back().p).y() - kRadius;
  const double turned = kGap / (2 * kHalfWidth);
  CHECK(height >= -1e-9);
  CHECK(height <= run.options.skin + turned * turned * 2 * kHalfWidth);
}

TEST_CASE("when the program cannot be solved the graphic tool stays and the force does not grow") {
  RenderingScene scene({{{0, 0, 0}, kRadius}});
  scene.capsules_W = {{{-0.5, 0, 0}, {0.5, 0, 0}, 0.34e-3}};
  ToolRun run(scene, pose_at({0, 0.02, 0}));
  const Pose X_WH = pose_at({0, 4e-3, 0});
  run.hold(X_WH, 20);
  const Vector3 p_before = run.state.X_WG.p;
  const double before = run.result.F_H_W.f.norm();
  CHECK(before > 1.0);
  // A vanishing stiffness makes the scaled program non-finite, which the solver refuses.
  run.stiffness.kt = 0.0;
  run.tick(X_WH);
  CHECK(run.result.status == ContactStatus::kQpFailed);
  CHECK(run.state.X_WG.p == p_before);
  CHECK(run.result.F_H_W.f.norm() <= before);
  run.stiffness.kt = 1000.0;
  CHECK(run.hold(X_WH, 5).F_H_W.f.norm() == within(before, 0.01));
}

TEST_CASE("a tool that only lags in free space renders no force") {
  RenderingScene scene({{{0, 0, 0}, kRadius}});
  scene.capsules_W = {{{-0.5, 0, 0}, {0.5, 0, 0}, 0.34e-3}};
  ToolRun run(scene, pose_at({0, 0.008, 0}));
  run.options.sub_steps = 1;
  // Leaving at 100 m/s from near the string, the tool cannot follow within one linearisation.
  for (int tick = 1; tick < 5; ++tick) {
    run.tick(pose_at({0, 0.008 + 0.1 * tick, 0}));
    CHECK(run.result.F_H_W.f.norm() == 0.0);
    CHECK(run.result.F_H_W.t.norm() == 0.0);
  }
}

}  // namespace hapticd::test
