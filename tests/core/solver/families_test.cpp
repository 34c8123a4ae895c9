// The Karush-Kuhn-Tucker conditions, in long double, on a million random problems: contact rows and
// every degenerate family, each solved cold and from a guess without sense.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <memory>

#include "core/solver/active_set.h"
#include "tests/core/solver/kkt_residual.h"
#include "tests/core/solver/qp_truth.h"
#include "tests/support/qp_degenerate_families.h"
#include "tests/support/qp_families.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// The promise of the solver, scaled.
constexpr long double kMaxResidual = 1e-9L;
/// What its correction of the multipliers reaches even in sharp wedges (measured: 3e-14).
constexpr long double kMaxImbalance = 1e-12L;

struct Worst {
  long double residual = 0.0L;
  long double imbalance = 0.0L;
  double reported_residual = 0.0;  ///< what kkt_residual says
  std::int64_t residual_trial = -1;
  std::int64_t not_optimal = 0;
  std::int64_t not_optimal_trial = -1;
  std::int64_t too_many_iterations = 0;
};

QpWarmStart senseless_guess(SplitMix64& random, const QpProblem& problem) {
  QpWarmStart warm;
  warm.count = random_count(random, 0, kMaxDenseUnknowns);
  for (std::size_t j = 0; j < static_cast<std::size_t>(warm.count); ++j) {
    warm.active[j] = static_cast<std::int16_t>(random_count(random, -2, problem.rows + 1));
  }
  return warm;
}

void judge(const QpProblem& problem, const QpSolution& solution, std::int64_t trial, Worst& worst) {
  const int most = kQpIterationsPerRow * problem.rows + problem.unknowns;
  if (solution.iterations > most) ++worst.too_many_iterations;
  if (solution.status != QpStatus::kOptimal) {
    ++worst.not_optimal;
    worst.not_optimal_trial = trial;
    return;
  }
  const KktViolations violations = kkt_violations(problem, solution);
  worst.imbalance = std::max(worst.imbalance, violations.stationarity);
  const long double residual = violations.worst();
  if (residual > worst.residual) {
    worst.residual = residual;
    worst.residual_trial = trial;
  }
  worst.reported_residual = std::max(worst.reported_residual, kkt_residual(problem, solution));
}

/// `make` fills a problem that has a solution.
template <typename Make>
void check_family(std::uint64_t seed, std::int64_t full_count, Make make) {
  const auto problem = std::make_unique<QpProblem>();
  const auto workspace = std::make_unique<QpWorkspace>();
  SplitMix64 random(seed);
  Worst worst;
  for (std::int64_t trial = 0; trial < scaled(full_count); ++trial) {
    make(random, *problem);
    QpSolution solution;
    solve_qp(*problem, QpWarmStart{}, *workspace, solution);
    judge(*problem, solution, trial, worst);
    solve_qp(*problem, senseless_guess(random, *problem), *workspace, solution);
    judge(*problem, solution, trial, worst);
  }
  CAPTURE(worst.residual_trial);
  CAPTURE(worst.not_optimal_trial);
  CHECK(worst.not_optimal == 0);
  CHECK(worst.too_many_iterations == 0);
  CHECK(worst.residual <= kMaxResidual);
  CHECK(worst.imbalance <= kMaxImbalance);
  CHECK(worst.reported_residual <= static_cast<double>(kMaxResidual));
}

}  // namespace

TEST_CASE("KKT: a tool pressed on objects, up to 64 rows") {
  check_family(101, 300'000, [](SplitMix64& random, QpProblem& problem) {
    contact_problem(random, random_count(random, 0, 64), problem);
  });
}

TEST_CASE("KKT: a tool pressed on objects, 256 rows") {
  check_family(102, 20'000, [](SplitMix64& random, QpProblem& problem) {
    contact_problem(random, kMaxQpRows, problem);
  });
}

TEST_CASE("KKT: any number of unknowns, weights 1e-3 to 1e9, rows without structure") {
  check_family(103, 150'000,
               [](SplitMix64& random, QpProblem& problem) { dense_problem(random, 60, problem); });
}

TEST_CASE("KKT: any number of unknowns, up to 256 rows") {
  check_family(104, 10'000, [](SplitMix64& random, QpProblem& problem) {
    dense_problem(random, kMaxQpRows, problem);
  });
}

TEST_CASE("KKT: rows that ignore the weights and so are nearly parallel") {
  check_family(105, 60'000, [](SplitMix64& random, QpProblem& problem) {
    mixed_weights_problem(random, 60, problem);
  });
}

TEST_CASE("KKT: sixty spheres on one string, a quarter of them copies") {
  check_family(106, 60'000, one_string_problem);
}

TEST_CASE("KKT: rows implied by others, with the implied bound or a weaker one") {
  check_family(107, 60'000, redundant_problem);
}

TEST_CASE("KKT: opposed rows that leave no width") {
  check_family(108, 60'000, zero_width_problem);
}

TEST_CASE("KKT: rows that differ or oppose each other by 1e-7") {
  check_family(109, 60'000, near_parallel_problem);
}

TEST_CASE("KKT: rows scaled by 1e-6 to 1e6") {
  check_family(110, 60'000, [](SplitMix64& random, QpProblem& problem) {
    dense_problem(random, 60, problem);
    scale_rows(random, problem);
  });
}

TEST_CASE("KKT: redundant and opposed rows scaled by 1e-6 to 1e6") {
  check_family(111, 60'000, [](SplitMix64& random, QpProblem& problem) {
    if (random.chance(0.5)) {
      redundant_problem(random, problem);
    } else {
      near_parallel_problem(random, problem);
    }
    scale_rows(random, problem);
  });
}

TEST_CASE("KKT: lengths counted in 1e-6 m and in 1e6 m") {
  check_family(112, 60'000, [](SplitMix64& random, QpProblem& problem) {
    contact_problem(random, random_count(random, 1, 40), problem);
    change_length_unit(random.chance(0.5) ? 1e-6 : 1e6, problem);
  });
}

TEST_CASE("KKT: far more planes through one point than unknowns") {
  check_family(113, 60'000, cone_tip_problem);
}

TEST_CASE("KKT: boxes with sides of zero width and sides given twice") {
  check_family(114, 60'000, box_problem);
}

TEST_CASE("KKT: wedges that open by 1e-7 to 1e-1, open or closed, among other planes") {
  check_family(115, 60'000, wedge_problem);
}

TEST_CASE("KKT: coefficients -1, 0 and 1, zero rows and ties everywhere") {
  check_family(116, 60'000, lattice_problem);
}

TEST_CASE("KKT: a tool on up to 64 strings, each row of one string or of none") {
  check_family(118, 20'000, many_strings_problem);
}

TEST_CASE("KKT: a target that satisfies every row, many exactly") {
  check_family(117, 60'000, satisfied_problem);
}

TEST_CASE("KKT: targets up to a thousand kilometres away from contacts of millimetres") {
  check_family(118, 60'000, [](SplitMix64& random, QpProblem& problem) {
    contact_problem(random, random_count(random, 1, 40), problem);
    const double away = random_magnitude(random, 0, 9);
    for (std::size_t k = 0; k < 6; ++k) problem.target[k] *= away;
  });
}

}  // namespace hapticd::test
