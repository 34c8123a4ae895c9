// Problems whose solution is a formula: half-space, wedge, corner, box, and the plain cases.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
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

struct Solver {
  QpProblem problem;
  QpWorkspace workspace;
  QpSolution solution;

  QpStatus solve() {
    solve_qp(problem, QpWarmStart{}, workspace, solution);
    return solution.status;
  }
};

/// `unknowns` of weight 1, target 0.
std::unique_ptr<Solver> make_solver(int unknowns) {
  auto solver = std::make_unique<Solver>();
  solver->problem.unknowns = unknowns;
  solver->problem.rows = 0;
  for (std::size_t k = 0; k < unknowns_of(solver->problem); ++k) {
    solver->problem.weight[k] = 1.0;
    solver->problem.target[k] = 0.0;
  }
  return solver;
}

}  // namespace

TEST_CASE("without rows the solution is the target, bit by bit") {
  const auto solver = make_solver(kMaxQpUnknowns);
  SplitMix64 random(1);
  for (std::size_t k = 0; k < kMaxQpUnknowns; ++k) {
    solver->problem.weight[k] = random_magnitude(random, -3, 9);
    solver->problem.target[k] = random.uniform(-1.0, 1.0);
  }
  REQUIRE(solver->solve() == QpStatus::kOptimal);
  CHECK(solver->solution.x == solver->problem.target);
  CHECK(solver->solution.active_count == 0);
  CHECK(solver->solution.iterations == 0);
}

TEST_CASE("a half-space gives the weighted projection and its multiplier") {
  SplitMix64 random(2);
  const auto solver = make_solver(1);
  QpProblem& problem = solver->problem;
  for (std::int64_t trial = 0; trial < scaled(20'000); ++trial) {
    start_problem(random, random_count(random, 1, kMaxDenseUnknowns), problem);
    const QpVector row = random_row(random, problem);
    const double length = scaled_length(problem, row);
    const double lacking = random.uniform(0.01, 1.0) * length;
    add_row(problem, row, value_at(problem, row, problem.target) + lacking);
    REQUIRE(solver->solve() == QpStatus::kOptimal);
    REQUIRE(solver->solution.active_count == 1);
    const double multiplier = lacking / (length * length);
    CHECK(solver->solution.multiplier[0] == within(multiplier, 1e-12));
    for (std::size_t k = 0; k < unknowns_of(problem); ++k) {
      const double x = problem.target[k] + multiplier * row[k] / problem.weight[k];
      const double error = std::sqrt(problem.weight[k]) * std::fabs(solver->solution.x[k] - x);
      CHECK(error <= 1e-13);
    }
  }
}

TEST_CASE("a wedge holds the point at its edge with the multipliers of its two sides") {
  // Sides at angles +a and -a to the vertical, tip at the origin, pressed down by depth p: by
  // symmetry each side pushes with p / (2 sin a).
  for (const double sine : {1e-6, 1e-3, 0.1, 0.5, 0.9}) {
    const auto solver = make_solver(2);
    const double cosine = std::sqrt(1.0 - sine * sine);
    add_row(solver->problem, {cosine, sine}, 0.0);
    add_row(solver->problem, {-cosine, sine}, 0.0);
    solver->problem.target[1] = -2e-3;
    REQUIRE(solver->solve() == QpStatus::kOptimal);
    REQUIRE(solver->solution.active_count == 2);
    CHECK(std::fabs(solver->solution.x[0]) <= 1e-18);
    CHECK(std::fabs(solver->solution.x[1]) <= 1e-18);
    CHECK(solver->solution.multiplier[0] == within(1e-3 / sine, 1e-9));
    CHECK(solver->solution.multiplier[1] == within(1e-3 / sine, 1e-9));
  }
}

TEST_CASE("the tip of a wedge that opens by 1e-7 is found to the last bits, wherever it lies") {
  // Both sides go through the tip without rounding; a residual in double is wrong by 1e-16, which
  // the wedge turns into 1e-9.
  const auto solver = make_solver(2);
  QpProblem& problem = solver->problem;
  SplitMix64 random(11);
  long double worst_residual = 0.0L;
  for (std::int64_t trial = 0; trial < scaled(20'000); ++trial) {
    problem.rows = 0;
    const QpVector tip = {short_number(random), short_number(random)};
    const QpVector side = {short_number(random), short_number(random)};
    const QpVector up = {-side[1], side[0]};
    if (side[0] * side[0] + side[1] * side[1] < 0.1) continue;
    QpVector left{};
    QpVector right{};
    for (std::size_t k = 0; k < 2; ++k) {
      left[k] = side[k] + 0x1p-23 * up[k];
      right[k] = -side[k] + 0x1p-23 * up[k];
      problem.target[k] = tip[k] - up[k];
    }
    add_row(problem, left, value_at(problem, left, tip));
    add_row(problem, right, value_at(problem, right, tip));
    REQUIRE(solver->solve() == QpStatus::kOptimal);
    REQUIRE(solver->solution.active_count == 2);
    CHECK(std::fabs(solver->solution.x[0] - tip[0]) <= 1e-15);
    CHECK(std::fabs(solver->solution.x[1] - tip[1]) <= 1e-15);
    worst_residual =
        std::max(worst_residual, kkt_violations(problem, solver->solution).stationarity);
  }
  CHECK(worst_residual <= 1e-15L);
}

TEST_CASE("a corner of as many orthogonal planes as unknowns holds every one of them") {
  for (int unknowns = 1; unknowns <= kMaxQpUnknowns; ++unknowns) {
    const auto solver = make_solver(unknowns);
    SplitMix64 random(static_cast<std::uint64_t>(unknowns));
    for (std::size_t k = 0; k < unknowns_of(solver->problem); ++k) {
      solver->problem.target[k] = -random.uniform(0.1, 1.0);
      QpVector row{};
      row[k] = random.uniform(0.1, 10.0);
      add_row(solver->problem, row, row[k]);
    }
    REQUIRE(solver->solve() == QpStatus::kOptimal);
    CHECK(solver->solution.active_count == unknowns);
    for (std::size_t k = 0; k < unknowns_of(solver->problem); ++k) {
      CHECK(solver->solution.x[k] == within(1.0, 1e-15));
    }
  }
}

TEST_CASE("a box clamps each unknown, with sides of zero width and sides given twice") {
  SplitMix64 random(3);
  const auto solver = make_solver(1);
  QpProblem& problem = solver->problem;
  for (std::int64_t trial = 0; trial < scaled(50'000); ++trial) {
    box_problem(random, problem);
    std::array<double, kMaxQpUnknowns> low;
    std::array<double, kMaxQpUnknowns> high;
    low.fill(-std::numeric_limits<double>::infinity());
    high.fill(std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < rows_of(problem); ++i) {
      for (std::size_t k = 0; k < unknowns_of(problem); ++k) {
        if (problem.row[k][i] > 0.0) low[k] = problem.bound[i];
        if (problem.row[k][i] < 0.0) high[k] = -problem.bound[i];
      }
    }
    REQUIRE(solver->solve() == QpStatus::kOptimal);
    for (std::size_t k = 0; k < unknowns_of(problem); ++k) {
      const double x = std::clamp(problem.target[k], low[k], high[k]);
      CHECK(std::sqrt(problem.weight[k]) * std::fabs(solver->solution.x[k] - x) <= 1e-13);
    }
  }
}

TEST_CASE("a target that satisfies every row, many of them exactly, is the solution") {
  SplitMix64 random(4);
  const auto solver = make_solver(1);
  for (std::int64_t trial = 0; trial < scaled(50'000); ++trial) {
    satisfied_problem(random, solver->problem);
    REQUIRE(solver->solve() == QpStatus::kOptimal);
    for (std::size_t k = 0; k < unknowns_of(solver->problem); ++k) {
      const double root = std::sqrt(solver->problem.weight[k]);
      CHECK(root * std::fabs(solver->solution.x[k] - solver->problem.target[k]) <= 1e-12);
    }
  }
}

TEST_CASE("of a hundred copies of one row one is active and carries the whole force") {
  const auto solver = make_solver(6);
  for (int copy = 0; copy < 100; ++copy) {
    add_row(solver->problem, {0.0, 1.0, 0.0, 0.0, 0.0, 0.0}, 2e-3);
  }
  REQUIRE(solver->solve() == QpStatus::kOptimal);
  REQUIRE(solver->solution.active_count == 1);
  CHECK(solver->solution.active[0] == 0);
  CHECK(solver->solution.multiplier[0] == within(2e-3, 1e-15));
  CHECK(solver->solution.x[1] == within(2e-3, 1e-15));
  CHECK(solver->solution.iterations == 1);
}

}  // namespace hapticd::test
