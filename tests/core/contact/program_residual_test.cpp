// The residual of a program's solution, and what a tick tells of it. Truth: the conditions of
// Karush, Kuhn and Tucker of a plane before a rigid tool, which one can write down.
#include "core/contact/program_residual.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/solver/active_set.h"
#include "tests/core/contact/rendering_fixture.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kDepth = 2e-3;

/// A tool in free space whose hand is kDepth beyond the plane through G with normal n.
struct Plane {
  explicit Plane(const Vector3& n) : normal(n) {
    run.tick(pose_at({0, 0, 0}));
    model.build(run.problem->view(), {-kDepth * n, Vector3::Zero()}, kToolDof);
    model.set_objective(problem);
    problem.rows = 1;
    problem.bound[0] = 0.0;
    for (std::size_t k = 0; k < kToolDof; ++k) {
      const SquareMatrix& basis = model.basis();
      problem.row[k][0] = basis(0, k) * n.x() + basis(1, k) * n.y() + basis(2, k) * n.z();
    }
    QpWorkspace workspace;
    solve_qp(problem, QpWarmStart{}, workspace, solution);
    REQUIRE(solution.active_count == 1);
  }
  /// Moves x by what takes the tool `dp` further: without contacts the metric is the coupling's.
  void move(const Vector3& dp) {
    for (Eigen::Index k = 0; k < 3; ++k) {
      solution.x[static_cast<std::size_t>(k)] += std::sqrt(run.stiffness.kt) * dp[k];
    }
  }
  [[nodiscard]] ProgramResidual residual() const {
    return program_residual(problem, solution, model, run.stiffness);
  }

  Vector3 normal;
  RenderingScene scene{{{{0, 0, 0}, 1e-3}}};
  ToolRun run{scene, pose_at({0, 0, 0})};
  Linearisation model;
  QpProblem problem;
  QpSolution solution;
};

}  // namespace

TEST_CASE("an optimum has no residual, and bears the coupling's force") {
  SplitMix64 random(3);
  for (int k = 0; k < 50; ++k) {
    const Plane plane(to_vector(random.direction()));
    CHECK(plane.residual().force < 1e-12);
    CHECK(plane.residual().gap < 1e-15);
    CHECK(plane.solution.multiplier[0] == doctest::Approx(plane.run.stiffness.kt * kDepth));
  }
}

TEST_CASE(
    "a solution that is moved off is off by that times kt, and its row by what lies along it") {
  SplitMix64 random(4);
  for (int k = 0; k < 50; ++k) {
    Plane plane(to_vector(random.direction()));
    const Vector3 dp = random.uniform(1e-9, 1e-4) * to_vector(random.direction());
    plane.move(dp);
    CHECK(plane.residual().force == doctest::Approx(plane.run.stiffness.kt * dp.norm()));
    CHECK(plane.residual().gap == within(std::abs(plane.normal.dot(dp)), 1e-6));
  }
}

TEST_CASE("a multiplier that is wrong by so many newtons is told as so many") {
  SplitMix64 random(5);
  for (int k = 0; k < 50; ++k) {
    Plane plane(to_vector(random.direction()));
    const double wrong = random.uniform(-1.0, 1.0);
    plane.solution.multiplier[0] += wrong;
    CHECK(plane.residual().force == doctest::Approx(std::abs(wrong)));
  }
}

TEST_CASE("a row that is violated without bearing force counts, and one that holds does not") {
  Plane plane(Vector3(0, 1, 0));
  plane.solution.active_count = 0;
  plane.solution.x.fill(0.0);
  plane.move({0, 1e-3, 0});
  CHECK(plane.residual().gap == 0.0);
  plane.move({0, -1.5e-3, 0});
  CHECK(plane.residual().gap == doctest::Approx(0.5e-3));
}

TEST_CASE("without a solution the residual is what coupling and force leave over") {
  const CouplingStiffness stiffness{500.0, 0.03};
  const PoseError error{{1e-3, 0, 0}, {0, 0.01, 0}};
  CHECK(unbalanced_force(stiffness, Quaternion::Identity(), error,
                         {{-0.5, 0, 0}, {0, -500.0 * 9e-4 * 0.01, 0}}) < 1e-12);
  CHECK(unbalanced_force(stiffness, Quaternion::Identity(), error,
                         {{-0.2, 0, 0}, {0, -500.0 * 9e-4 * 0.01, 0}}) == doctest::Approx(0.3));
}

TEST_CASE("what begins to bear force in a tick is within reach of the tool, or of the hand") {
  SplitMix64 random(6);
  int begun = 0;
  for (std::int64_t sweep = std::max<std::int64_t>(40, scaled(400)); sweep > 0; --sweep) {
    RenderingScene scene({{{0, 0, 0}, 0.7e-3}});
    for (const double z : {-1.5e-3, -0.5e-3, 0.5e-3, 1.5e-3}) {
      scene.capsules_W.push_back({{-0.5, 0, z}, {0.5, 0, z}, 2e-5});
    }
    ToolRun run(scene, pose_at({0, 9e-3, 0}));
    run.options.sub_steps = 1;
    const auto gap_at = [&](const Vector3& p, std::int32_t line) {
      const Vector3& p_A = scene.capsules_W[static_cast<std::size_t>(line)].p_A;
      return std::hypot(p.y() - p_A.y(), p.z() - p_A.z()) - 0.7e-3 - 2e-5;
    };
    std::array<bool, 4> pressed{};
    for (int tick = 0; tick < 20; ++tick) {
      const Vector3 p(0, random.uniform(-4e-3, 9e-3), random.uniform(-6e-3, 6e-3));
      run.tick(pose_at(p));
      std::array<bool, 4> now{};
      for (int k = 0; k < run.result.active_count; ++k) {
        const ActivePair& pair = run.state.active[static_cast<std::size_t>(k)];
        const auto line = static_cast<std::size_t>(pair.key.obstacle);
        now[line] = pair.multiplier > 0.0;
        if (!now[line] || pressed[line]) continue;
        ++begun;
        const double gap =
            std::min(gap_at(run.state.X_WG.p, pair.key.obstacle), gap_at(p, pair.key.obstacle));
        CHECK(gap < 4.2e-5);
      }
      if (run.result.active_count == 0) CHECK(run.result.F_H_W.f.norm() == 0.0);
      pressed = now;
    }
  }
  CHECK(begun > 10);
}

}  // namespace hapticd::test
