// The solver against the best of all active sets, tried one by one in long double.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <memory>

#include "core/solver/active_set.h"
#include "tests/core/solver/qp_truth.h"
#include "tests/support/qp_families.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

struct Tally {
  int feasible = 0;
  int infeasible = 0;
};

/// Solves and compares status and point with the exhaustive optimum.
void check_against_all_sets(const QpProblem& problem, QpWorkspace& workspace, Tally& tally) {
  QpSolution solution;
  solve_qp(problem, QpWarmStart{}, workspace, solution);
  const ExhaustiveOptimum truth = exhaustive_optimum(problem);
  ++(truth.feasible ? tally.feasible : tally.infeasible);
  REQUIRE(solution.status == (truth.feasible ? QpStatus::kOptimal : QpStatus::kInfeasible));
  if (!truth.feasible) return;
  for (std::size_t k = 0; k < unknowns_of(problem); ++k) {
    const long double root = std::sqrt(static_cast<long double>(problem.weight[k]));
    CHECK(root * std::abs(solution.x[k] - truth.x[k]) <= 1e-9L);
  }
}

}  // namespace

TEST_CASE("the solution of a small problem is the best of all active sets") {
  const auto problem = std::make_unique<QpProblem>();
  const auto workspace = std::make_unique<QpWorkspace>();
  SplitMix64 random(9);
  Tally tally;
  for (std::int64_t trial = 0; trial < scaled(50'000); ++trial) {
    start_problem(random, random_count(random, 1, 4), *problem);
    const int rows = random_count(random, 0, 10);
    while (problem->rows < rows) {
      // Bounds of either sign: about a third of the problems have no solution.
      const QpVector row = random_row(random, *problem);
      add_row(*problem, row, random.uniform(-1.0, 0.5) * scaled_length(*problem, row));
    }
    check_against_all_sets(*problem, *workspace, tally);
  }
  CHECK(tally.feasible > tally.infeasible);
  CHECK(tally.infeasible > 0);
}

TEST_CASE("the solution of a small problem full of ties is the best of all active sets") {
  const auto problem = std::make_unique<QpProblem>();
  const auto workspace = std::make_unique<QpWorkspace>();
  SplitMix64 random(10);
  Tally tally;
  for (std::int64_t trial = 0; trial < scaled(50'000); ++trial) {
    problem->unknowns = random_count(random, 1, 4);
    problem->rows = 0;
    for (std::size_t k = 0; k < unknowns_of(*problem); ++k) {
      problem->weight[k] = 1.0;
      problem->target[k] = random_count(random, -3, 3);
    }
    const int rows = random_count(random, 0, 9);
    while (problem->rows < rows) {
      QpVector row{};
      for (std::size_t k = 0; k < unknowns_of(*problem); ++k) row[k] = random_count(random, -1, 1);
      add_row(*problem, row, random_count(random, -2, 1));
    }
    check_against_all_sets(*problem, *workspace, tally);
  }
  CHECK(tally.feasible > 0);
  CHECK(tally.infeasible > 0);
}

}  // namespace hapticd::test
