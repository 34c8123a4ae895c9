// The loops over all rows: against sums in long double, and the baseline against AVX2, bit by bit,
// for every number of rows and unknowns that leaves a remainder.
#include "core/solver/row_scan.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>

#include "core/math/cpu.h"
#include "core/solver/active_set.h"
#include "tests/support/qp_families.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

using Point = std::array<double, kMaxQpUnknowns>;

/// Allows what the processor has again, however the test ends.
struct RestoreCpu {
  ~RestoreCpu() { allow_avx2(true); }
};

struct Scan {
  RowValues violation;
  RowValues inverse_length;
  RowSurvey survey;
  bool finite;
  RowIndex most;
  RowIndex most_in_one_pass;
};

void scan(const QpProblem& problem, const Point& x, const Point& factor, Scan& result) {
  std::memset(static_cast<void*>(&result), 0, sizeof(Scan));
  result.survey = evaluate_violations(problem, x.data(), result.violation);
  result.finite = inverse_row_lengths(problem, factor.data(), result.inverse_length);
  const RowMeasure measure{result.inverse_length, 1e-12};
  result.most = most_violated(result.violation, measure, rows_of(problem));
  result.most_in_one_pass = evaluate_most_violated(problem, x.data(), measure, result.violation);
}

bool same_bits(const RowValues& a, const RowValues& b) {
  return std::equal(a.value.begin(), a.value.end(), b.value.begin(), [](double x, double y) {
    return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
  });
}

/// Unit weights and random rows.
void fill(SplitMix64& random, int unknowns, int rows, QpProblem& problem) {
  problem.unknowns = unknowns;
  problem.rows = 0;
  problem.weight.fill(1.0);
  while (problem.rows < rows) {
    const QpVector row = random_row(random, problem);
    add_row(problem, row, random.uniform(-1.0, 1.0));
  }
}

Point random_factors(SplitMix64& random) {
  Point factor;
  for (double& entry : factor) entry = random.uniform(0.1, 2.0);
  return factor;
}

}  // namespace

TEST_CASE("violations, lengths and the most violated row agree with sums in long double") {
  const auto problem = std::make_unique<QpProblem>();
  const auto result = std::make_unique<Scan>();
  SplitMix64 random(301);
  for (int rows = 0; rows <= kMaxQpRows; ++rows) {
    fill(random, 1 + rows % kMaxQpUnknowns, rows, *problem);
    const Point x = random_factors(random);
    const Point factor = random_factors(random);
    scan(*problem, x, factor, *result);
    long double largest = 0.0L;
    int positive = 0;
    for (std::size_t i = 0; i < rows_of(*problem); ++i) {
      long double violation = problem->bound[i];
      long double squared = 0.0L;
      for (std::size_t k = 0; k < unknowns_of(*problem); ++k) {
        violation -= static_cast<long double>(problem->row[k][i]) * x[k];
        const long double c = static_cast<long double>(problem->row[k][i]) * factor[k];
        squared += c * c;
      }
      CHECK(std::abs(result->violation.value[i] - violation) <= 1e-13L);
      CHECK(std::abs(result->inverse_length.value[i] * std::sqrt(squared) - 1.0L) <= 0.04L);
      largest = std::max(largest, violation * result->inverse_length.value[i]);
      if (violation > 0.0L) ++positive;
    }
    CHECK(result->finite);
    CHECK(result->survey.finite);
    CHECK(result->survey.positive == positive);
    CHECK(result->most == result->most_in_one_pass);
    if (positive == 0) {
      CHECK(result->most == kMaxQpRows);
    } else {
      const std::size_t i = result->most;
      REQUIRE(i < rows_of(*problem));
      const double chosen = result->violation.value[i] * result->inverse_length.value[i];
      CHECK(std::abs(chosen - largest) <= 1e-12L);
    }
  }
}

TEST_CASE("of equally violated rows the lowest is the most violated") {
  const auto problem = std::make_unique<QpProblem>();
  const auto result = std::make_unique<Scan>();
  SplitMix64 random(302);
  const RestoreCpu restore;
  for (const bool avx2 : {false, true}) {
    allow_avx2(avx2);
    for (int trial = 0; trial < 2000; ++trial) {
      fill(random, 6, random_count(random, 2, kMaxQpRows), *problem);
      const Point x{};
      const Point factor = random_factors(random);
      const QpVector winner = random_row(random, *problem);
      std::size_t lowest = kMaxQpRows;
      for (int copy = random_count(random, 1, 6); copy > 0; --copy) {
        const std::size_t i = random.below(rows_of(*problem));
        for (std::size_t k = 0; k < 6; ++k) problem->row[k][i] = winner[k];
        problem->bound[i] = 1e3;
        lowest = std::min(lowest, i);
      }
      scan(*problem, x, factor, *result);
      REQUIRE(result->most == lowest);
      REQUIRE(result->most_in_one_pass == lowest);
    }
  }
}

TEST_CASE("no row is most violated when none is beyond the threshold") {
  RowValues violation;
  RowValues inverse_length;
  violation.value.fill(1e-3);
  inverse_length.value.fill(1.0);
  CHECK(most_violated(violation, {inverse_length, 1e-3}, 256) == kMaxQpRows);
  CHECK(most_violated(violation, {inverse_length, 0.999e-3}, 256) == 0);
  CHECK(most_violated(violation, {inverse_length, 0.0}, 0) == kMaxQpRows);
  violation.value.fill(-1.0);
  CHECK(most_violated(violation, {inverse_length, 0.0}, 256) == kMaxQpRows);
  violation.value[255] = std::numeric_limits<double>::infinity();
  CHECK(most_violated(violation, {inverse_length, 0.0}, 256) == 255);
  CHECK(most_violated(violation, {inverse_length, 0.0}, 255) == kMaxQpRows);
}

TEST_CASE("a row that is not finite is told") {
  const auto problem = std::make_unique<QpProblem>();
  const auto result = std::make_unique<Scan>();
  SplitMix64 random(303);
  for (int rows = 1; rows <= 40; ++rows) {
    fill(random, 6, rows, *problem);
    const std::size_t i = random.below(rows_of(*problem));
    problem->row[random.below(6)][i] = rows % 2 == 0 ? std::numeric_limits<double>::quiet_NaN()
                                                     : -std::numeric_limits<double>::infinity();
    const Point x = random_factors(random);
    scan(*problem, x, x, *result);
    CHECK_FALSE(result->survey.finite);
    CHECK_FALSE(result->finite);
  }
}

TEST_CASE("AVX2 and baseline loops give the same bits") {
  const RestoreCpu restore;
  if (!allow_avx2(true)) MESSAGE("this processor has no AVX2: one path was compared with itself");
  const auto problem = std::make_unique<QpProblem>();
  const auto baseline = std::make_unique<Scan>();
  const auto avx2 = std::make_unique<Scan>();
  SplitMix64 random(304);
  for (int unknowns = 1; unknowns <= kMaxQpUnknowns; ++unknowns) {
    for (int rows = 0; rows <= 70; ++rows) {
      fill(random, unknowns, rows, *problem);
      const Point x = random_factors(random);
      const Point factor = random_factors(random);
      allow_avx2(false);
      scan(*problem, x, factor, *baseline);
      allow_avx2(true);
      scan(*problem, x, factor, *avx2);
      REQUIRE(same_bits(baseline->violation, avx2->violation));
      REQUIRE(same_bits(baseline->inverse_length, avx2->inverse_length));
      REQUIRE(baseline->survey.positive == avx2->survey.positive);
      REQUIRE(baseline->most == avx2->most);
      REQUIRE(baseline->most_in_one_pass == avx2->most_in_one_pass);
    }
  }
}

TEST_CASE("AVX2 and baseline solutions are the same bits") {
  const RestoreCpu restore;
  const auto problem = std::make_unique<QpProblem>();
  const auto workspace = std::make_unique<QpWorkspace>();
  SplitMix64 random(305);
  for (std::int64_t trial = 0; trial < scaled(50'000); ++trial) {
    if (random.chance(0.5)) {
      contact_problem(random, random_count(random, 0, kMaxQpRows), *problem);
    } else {
      dense_problem(random, 70, *problem);
    }
    QpSolution a;
    QpSolution b;
    allow_avx2(false);
    solve_qp(*problem, {}, *workspace, a);
    allow_avx2(true);
    solve_qp(*problem, {}, *workspace, b);
    REQUIRE(a.status == b.status);
    REQUIRE(a.active_count == b.active_count);
    REQUIRE(a.iterations == b.iterations);
    for (std::size_t k = 0; k < unknowns_of(*problem); ++k) REQUIRE(a.x[k] == b.x[k]);
    for (std::size_t j = 0; j < static_cast<std::size_t>(a.active_count); ++j) {
      REQUIRE(a.active[j] == b.active[j]);
      REQUIRE(a.multiplier[j] == b.multiplier[j]);
    }
  }
}

}  // namespace hapticd::test
