// What must not change the solution: the guess, the order of the rows, their scale, the unit of
// length. Problems here are well conditioned, so that points can be compared.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <numeric>

#include "core/solver/active_set.h"
#include "tests/core/solver/qp_truth.h"
#include "tests/support/qp_degenerate_families.h"
#include "tests/support/qp_families.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// Problems of bounded sharpness, one kind after the other.
void comparable_problem(SplitMix64& random, QpProblem& problem) {
  switch (random.below(5)) {
    case 0:
      contact_problem(random, random_count(random, 0, kMaxQpRows), problem);
      break;
    case 1:
      contact_problem(random, random_count(random, 1, 20), problem);
      break;
    case 2:
      one_string_problem(random, problem);
      break;
    case 3:
      box_problem(random, problem);
      break;
    default:
      lattice_problem(random, problem);
      break;
  }
}

QpSolution solve(const QpProblem& problem, const QpWarmStart& warm, QpWorkspace& workspace) {
  QpSolution solution;
  solve_qp(problem, warm, workspace, solution);
  REQUIRE(solution.status == QpStatus::kOptimal);
  return solution;
}

bool same_bits(const QpProblem& problem, const QpSolution& a, const QpSolution& b) {
  return std::equal(a.x.begin(), a.x.begin() + problem.unknowns, b.x.begin());
}

/// Row i of the result is row order[i] of the problem.
void permute_rows(const QpProblem& problem, const std::array<std::size_t, kMaxQpRows>& order,
                  QpProblem& permuted) {
  permuted.unknowns = problem.unknowns;
  permuted.rows = problem.rows;
  permuted.weight = problem.weight;
  permuted.target = problem.target;
  for (std::size_t i = 0; i < rows_of(problem); ++i) {
    permuted.bound[i] = problem.bound[order[i]];
    for (std::size_t k = 0; k < unknowns_of(problem); ++k) {
      permuted.row[k][i] = problem.row[k][order[i]];
    }
  }
}

}  // namespace

TEST_CASE("any guess of the active rows gives the cold solution to 1e-12") {
  const auto problem = std::make_unique<QpProblem>();
  const auto workspace = std::make_unique<QpWorkspace>();
  SplitMix64 random(201);
  long double worst = 0.0L;
  for (std::int64_t trial = 0; trial < scaled(100'000); ++trial) {
    comparable_problem(random, *problem);
    const QpSolution cold = solve(*problem, {}, *workspace);
    QpWarmStart warm;
    warm.count = random_count(random, 0, kMaxDenseUnknowns);
    for (std::size_t j = 0; j < static_cast<std::size_t>(warm.count); ++j) {
      // Rows that are active, any rows, copies, and rows that do not exist.
      const std::size_t own = random.below(kMaxDenseUnknowns);
      const bool known = random.chance(0.5) && static_cast<int>(own) < cold.active_count;
      warm.active[j] = known ? cold.active[own]
                             : static_cast<std::int16_t>(random_count(random, -3, kMaxQpRows));
    }
    const QpSolution guessed = solve(*problem, warm, *workspace);
    worst = std::max(worst, scaled_difference(*problem, cold, guessed));
  }
  CHECK(worst <= 1e-12L);
}

TEST_CASE("the solution's own active rows as a guess are confirmed without an iteration") {
  const auto problem = std::make_unique<QpProblem>();
  const auto workspace = std::make_unique<QpWorkspace>();
  SplitMix64 random(202);
  for (std::int64_t trial = 0; trial < scaled(50'000); ++trial) {
    contact_problem(random, random_count(random, 1, 64), *problem);
    const QpSolution cold = solve(*problem, {}, *workspace);
    QpWarmStart warm;
    warm.count = cold.active_count;
    warm.active = cold.active;
    const QpSolution guessed = solve(*problem, warm, *workspace);
    CHECK(guessed.iterations == 0);
    CHECK(guessed.active_count == cold.active_count);
  }
}

TEST_CASE("the order of the rows does not change the point") {
  const auto problem = std::make_unique<QpProblem>();
  const auto permuted = std::make_unique<QpProblem>();
  const auto workspace = std::make_unique<QpWorkspace>();
  SplitMix64 random(203);
  long double worst = 0.0L;
  std::array<std::size_t, kMaxQpRows> order{};
  for (std::int64_t trial = 0; trial < scaled(50'000); ++trial) {
    comparable_problem(random, *problem);
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t i = rows_of(*problem); i > 1; --i) {
      std::swap(order[i - 1], order[random.below(i)]);
    }
    permute_rows(*problem, order, *permuted);
    const QpSolution a = solve(*problem, {}, *workspace);
    const QpSolution b = solve(*permuted, {}, *workspace);
    worst = std::max(worst, scaled_difference(*problem, a, b));
  }
  CHECK(worst <= 1e-12L);
}

TEST_CASE("rows scaled by powers of two from 1e-6 to 1e6 give the same bits") {
  const auto problem = std::make_unique<QpProblem>();
  const auto workspace = std::make_unique<QpWorkspace>();
  SplitMix64 random(204);
  for (std::int64_t trial = 0; trial < scaled(50'000); ++trial) {
    comparable_problem(random, *problem);
    const QpSolution before = solve(*problem, {}, *workspace);
    scale_rows(random, *problem);
    const QpSolution after = solve(*problem, {}, *workspace);
    REQUIRE(same_bits(*problem, before, after));
    REQUIRE(before.iterations == after.iterations);
  }
}

TEST_CASE("rows scaled by any factor from 1e-6 to 1e6 give the same point") {
  const auto problem = std::make_unique<QpProblem>();
  const auto workspace = std::make_unique<QpWorkspace>();
  SplitMix64 random(205);
  long double worst = 0.0L;
  for (std::int64_t trial = 0; trial < scaled(50'000); ++trial) {
    comparable_problem(random, *problem);
    const QpSolution before = solve(*problem, {}, *workspace);
    for (std::size_t i = 0; i < rows_of(*problem); ++i) {
      const double factor = random_magnitude(random, -6, 6);
      for (std::size_t k = 0; k < unknowns_of(*problem); ++k) problem->row[k][i] *= factor;
      problem->bound[i] *= factor;
    }
    const QpSolution after = solve(*problem, {}, *workspace);
    worst = std::max(worst, scaled_difference(*problem, before, after));
  }
  CHECK(worst <= 1e-12L);
}

TEST_CASE("the unit of length changes nothing but the numbers' unit") {
  const auto problem = std::make_unique<QpProblem>();
  const auto workspace = std::make_unique<QpWorkspace>();
  SplitMix64 random(206);
  for (std::int64_t trial = 0; trial < scaled(20'000); ++trial) {
    contact_problem(random, random_count(random, 1, 64), *problem);
    const QpSolution metres = solve(*problem, {}, *workspace);
    for (const double unit : {0x1p-20, 0x1p40}) {
      change_length_unit(unit, *problem);
      QpSolution other = solve(*problem, {}, *workspace);
      // The first turn leaves units of 2^-20 m, the second of 2^20 m.
      const double metre = unit < 1.0 ? 0x1p-20 : 0x1p20;
      for (std::size_t k = 0; k < 3; ++k) other.x[k] *= metre;
      REQUIRE(same_bits(*problem, metres, other));
    }
  }
}

}  // namespace hapticd::test
