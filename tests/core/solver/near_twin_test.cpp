// Rows that are nearly the same, as two halves of a string give them that meet in its end: which of
// them bears the load is up to rounding, but together they must balance the target, whatever rows a
// warm start guesses.
#include <doctest/doctest.h>

#include <cmath>

#include "core/solver/active_set.h"
#include "tests/core/solver/kkt_residual.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr double kResidual = 1e-9;

/// `rows` rows around one direction, their entries apart by about `apart`, and a target that
/// violates them all.
QpProblem near_twins(SplitMix64& random, int unknowns, int rows, double apart) {
  QpProblem problem;
  problem.unknowns = unknowns;
  problem.rows = rows;
  std::array<double, kMaxQpUnknowns> common{};
  double square = 0.0;
  for (int k = 0; k < unknowns; ++k) {
    const auto c = static_cast<std::size_t>(k);
    common[c] = random.uniform(-1.0, 1.0);
    square += common[c] * common[c];
  }
  for (int k = 0; k < unknowns; ++k) {
    const auto c = static_cast<std::size_t>(k);
    problem.weight[c] = 1.0;
    problem.target[c] = -0.1 * common[c] / std::sqrt(square) + random.uniform(-0.01, 0.01);
    for (int i = 0; i < rows; ++i) {
      problem.row[c][static_cast<std::size_t>(i)] = common[c] + random.uniform(-apart, apart);
    }
  }
  for (int i = 0; i < rows; ++i) problem.bound[static_cast<std::size_t>(i)] = 0.0;
  return problem;
}

}  // namespace

TEST_CASE("rows that are nearly the same balance the target together, whatever the warm start") {
  SplitMix64 random(77);
  QpWorkspace workspace;
  QpSolution solution;
  double worst = 0.0;
  const std::int64_t count = scaled(100'000);
  for (std::int64_t i = 0; i < count; ++i) {
    const int unknowns = random.chance(0.5) ? 6 : 8;
    const int rows = 2 + static_cast<int>(random.below(3));
    const double apart = std::pow(10.0, random.uniform(-16.0, -4.0));
    const QpProblem problem = near_twins(random, unknowns, rows, apart);
    QpWarmStart warm;
    for (int k = 0; k < rows; ++k) {
      if (random.chance(0.8)) {
        warm.active[static_cast<std::size_t>(warm.count++)] = static_cast<std::int16_t>(k);
      }
    }
    solve_qp(problem, warm, workspace, solution);
    REQUIRE(solution.status == QpStatus::kOptimal);
    worst = std::max(worst, kkt_residual(problem, solution));
  }
  MESSAGE("largest residual of " << count << " programs: " << worst);
  CHECK(worst <= kResidual);
}

}  // namespace hapticd::test
