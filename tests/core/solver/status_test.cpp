// What the solver says about problems without a solution, without sense, or at the edge of either.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>

#include "core/solver/active_set.h"
#include "tests/core/solver/qp_truth.h"
#include "tests/support/qp_degenerate_families.h"
#include "tests/support/qp_families.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct Solver {
  QpProblem problem;
  QpWorkspace workspace;
  QpSolution solution;

  QpStatus solve(const QpWarmStart& warm = {}) {
    solve_qp(problem, warm, workspace, solution);
    return solution.status;
  }
};

/// Every row once as a guess, so that a warm start meets each of them too.
QpWarmStart guess(SplitMix64& random, const QpProblem& problem) {
  QpWarmStart warm;
  warm.count = random_count(random, 0, kMaxDenseUnknowns);
  for (int j = 0; j < warm.count; ++j) {
    warm.active[static_cast<std::size_t>(j)] =
        static_cast<std::int16_t>(random_count(random, -1, problem.rows));
  }
  return warm;
}

}  // namespace

TEST_CASE("walls that leave 1e-9 m of room are feasible, walls that lack 1e-9 m are not") {
  const auto solver = std::make_unique<Solver>();
  for (const double unit : {1.0, 1e-6, 1e6}) {
    SplitMix64 random(5);
    for (std::int64_t trial = 0; trial < scaled(30'000); ++trial) {
      const bool feasible = random.chance(0.5);
      const double width = feasible ? 1e-9 : -1e-9;
      if (random.chance(0.5)) {
        slab_problem(random, width, solver->problem);
      } else {
        prism_problem(random, width, solver->problem);
      }
      change_length_unit(unit, solver->problem);
      if (random.chance(0.5)) scale_rows(random, solver->problem);
      const QpStatus expected = feasible ? QpStatus::kOptimal : QpStatus::kInfeasible;
      REQUIRE(solver->solve() == expected);
      REQUIRE(solver->solve(guess(random, solver->problem)) == expected);
      if (feasible) CHECK(kkt_violations(solver->problem, solver->solution).worst() <= 1e-9L);
    }
  }
}

TEST_CASE("a lid too low for a wedge of 1e-6 is infeasible or satisfied to 1e-9, never less") {
  // Sides that yield by rounding make room under the lid, and lack nothing that counts: which of
  // the two is said depends on the rows chosen. Only a lid that touches is certainly feasible.
  const auto solver = std::make_unique<Solver>();
  QpProblem& problem = solver->problem;
  SplitMix64 random(12);
  for (std::int64_t trial = 0; trial < scaled(20'000); ++trial) {
    problem.unknowns = 2;
    problem.rows = 0;
    const QpVector side = {short_number(random), short_number(random)};
    const QpVector up = {-side[1], side[0]};
    if (side[0] * side[0] + side[1] * side[1] < 0.1) continue;
    for (std::size_t k = 0; k < 2; ++k) {
      problem.weight[k] = 1.0;
      problem.target[k] = random.uniform(-1.0, 1.0) - up[k];
    }
    add_row(problem, {side[0] + 0x1p-20 * up[0], side[1] + 0x1p-20 * up[1]}, 0.0);
    add_row(problem, {-side[0] + 0x1p-20 * up[0], -side[1] + 0x1p-20 * up[1]}, 0.0);
    const bool touches = random.chance(0.2);
    add_row(problem, {-up[0], -up[1]}, touches ? 0.0 : random_magnitude(random, -10, -4));
    for (const QpWarmStart& warm : {QpWarmStart{}, guess(random, problem)}) {
      const QpStatus status = solver->solve(warm);
      if (status == QpStatus::kOptimal) {
        CHECK(kkt_violations(problem, solver->solution).worst() <= 1e-9L);
      } else {
        REQUIRE(status == QpStatus::kInfeasible);
        REQUIRE_FALSE(touches);
      }
    }
  }
}

TEST_CASE("the row named infeasible contradicts the active ones") {
  const auto solver = std::make_unique<Solver>();
  solver->problem.unknowns = 1;
  solver->problem.rows = 0;
  solver->problem.weight[0] = 1000.0;
  solver->problem.target[0] = 0.0;
  add_row(solver->problem, {1.0}, -3.0);
  add_row(solver->problem, {1.0}, 2.0);
  add_row(solver->problem, {-1.0}, -1.0);
  REQUIRE(solver->solve() == QpStatus::kInfeasible);
  CHECK(solver->solution.active_count == 1);
  const int named = solver->solution.infeasible_row;
  CHECK(named + solver->solution.active[0] == 3);
}

TEST_CASE("a zero row is satisfied when its bound is not positive and impossible otherwise") {
  const auto solver = std::make_unique<Solver>();
  SplitMix64 random(6);
  for (int trial = 0; trial < 200; ++trial) {
    contact_problem(random, random_count(random, 0, 40), solver->problem);
    add_row(solver->problem, QpVector{}, random.chance(0.5) ? 0.0 : -1e-3);
    REQUIRE(solver->solve() == QpStatus::kOptimal);
    CHECK(kkt_violations(solver->problem, solver->solution).worst() <= 1e-9L);
    add_row(solver->problem, QpVector{}, 1e-12);
    REQUIRE(solver->solve() == QpStatus::kInfeasible);
    CHECK(solver->solution.infeasible_row == solver->problem.rows - 1);
  }
}

TEST_CASE(
    "a number that is not finite, or a weight that is not positive, is refused wherever it is") {
  const auto solver = std::make_unique<Solver>();
  QpProblem& problem = solver->problem;
  SplitMix64 random(7);
  for (int trial = 0; trial < 2000; ++trial) {
    contact_problem(random, random_count(random, 1, kMaxQpRows), problem);
    const std::size_t k = random.below(6);
    const std::size_t i = random.below(rows_of(problem));
    constexpr std::array<double, 3> kBad = {kNan, kInfinity, -kInfinity};
    const double bad = kBad[random.below(3)];
    switch (random.below(5)) {
      case 0:
        problem.weight[k] = bad;
        break;
      case 1:
        problem.target[k] = bad;
        break;
      case 2:
        problem.row[k][i] = bad;
        break;
      case 3:
        problem.bound[i] = bad;
        break;
      default:
        problem.weight[k] = random.chance(0.5) ? 0.0 : -1.0;
        break;
    }
    REQUIRE(solver->solve() == QpStatus::kInvalid);
    REQUIRE(solver->solve(guess(random, problem)) == QpStatus::kInvalid);
  }
}

TEST_CASE("one unknown between two bounds, at every ratio of their scales") {
  const auto solver = std::make_unique<Solver>();
  QpProblem& problem = solver->problem;
  for (int scale = -100; scale <= 100; scale += 5) {
    problem.unknowns = 1;
    problem.rows = 0;
    problem.weight[0] = 1e3;
    problem.target[0] = 7e-3;
    const double factor = power_of_ten(scale);
    add_row(problem, {factor}, factor * 1e-3);
    add_row(problem, {-1.0}, -2e-3);
    REQUIRE(solver->solve() == QpStatus::kOptimal);
    CHECK(solver->solution.x[0] == within(2e-3, 1e-15));
    problem.target[0] = -7e-3;
    REQUIRE(solver->solve() == QpStatus::kOptimal);
    CHECK(solver->solution.x[0] == within(1e-3, 1e-15));
    CHECK(solver->solution.multiplier[0] * factor == within(8.0, 1e-14));
  }
}

TEST_CASE("what lies beyond the unknowns and rows, and in the workspace, does not matter") {
  auto clean = std::make_unique<Solver>();
  auto dirty = std::make_unique<Solver>();
  SplitMix64 random(8);
  for (std::int64_t trial = 0; trial < scaled(20'000); ++trial) {
    // Every byte 0xff: all doubles are not a number, all indices are far outside.
    std::memset(static_cast<void*>(&dirty->problem), 0xff, sizeof(QpProblem));
    std::memset(static_cast<void*>(&dirty->workspace), 0xff, sizeof(QpWorkspace));
    std::memset(static_cast<void*>(&dirty->solution), 0xff, sizeof(QpSolution));
    std::memset(static_cast<void*>(&clean->problem), 0, sizeof(QpProblem));
    SplitMix64 same = random;
    dense_problem(random, 70, clean->problem);
    dense_problem(same, 70, dirty->problem);
    QpWarmStart warm = guess(random, clean->problem);
    clean->solve(warm);
    for (std::size_t j = static_cast<std::size_t>(warm.count); j < kMaxQpUnknowns; ++j) {
      warm.active[j] = 12345;
    }
    dirty->solve(warm);
    REQUIRE(dirty->solution.status == clean->solution.status);
    REQUIRE(dirty->solution.active_count == clean->solution.active_count);
    REQUIRE(dirty->solution.iterations == clean->solution.iterations);
    for (std::size_t k = 0; k < unknowns_of(clean->problem); ++k) {
      REQUIRE(dirty->solution.x[k] == clean->solution.x[k]);
    }
  }
}

}  // namespace hapticd::test
