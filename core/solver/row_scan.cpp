// Each loop is a plain body that compilers turn into lanes, inlined into a baseline and an AVX2
// function. The search compares doubles by their bits as integers, which order positive numbers
// alike: compilers make no lanes of a floating-point maximum. The low byte of the bits is replaced
// by the row, so that the maximum carries its place with it.
#include "core/solver/row_scan.h"

#include <bit>
#include <cstddef>
#include <cstdint>

#include "core/math/cpu.h"

namespace hapticd {
namespace {

constexpr std::size_t kTool = kToolDof;

using Key = std::int64_t;
constexpr Key kRowMask = kMaxQpRows - 1;
static_assert(kMaxQpRows == 256, "a row is a byte of its key");

/// Of equal values the lowest row has the largest key.
[[gnu::always_inline]] inline Key key_of(double value, std::size_t row) noexcept {
  return (std::bit_cast<Key>(value) | kRowMask) - static_cast<Key>(row);
}

[[gnu::always_inline]] inline RowIndex row_above(Key best, double threshold) noexcept {
  const bool above = best > (std::bit_cast<Key>(threshold) | kRowMask);
  return above ? static_cast<RowIndex>(kRowMask - (best & kRowMask)) : kMaxQpRows;
}

/// 0 when `value` is finite.
[[gnu::always_inline]] inline Key poison_of(double value) noexcept {
  // NOLINTNEXTLINE(misc-redundant-expression): nothing is left of a finite value alone
  return std::bit_cast<Key>(value - value);
}

/// The columns [first, first + C) of all rows; partial[i] holds the fold of row i so far.
template <std::size_t C, bool First, bool Last, typename Start, typename Combine, typename Finish>
[[gnu::always_inline]] inline void fold_columns(const QpProblem& problem, std::size_t first,
                                                const double* factor, double* __restrict partial,
                                                Start start, Combine combine,
                                                Finish finish) noexcept {
  std::array<double, C> f;
  for (std::size_t c = 0; c < C; ++c) f[c] = factor[first + c];
  for (std::size_t i = 0; i < static_cast<std::size_t>(problem.rows); ++i) {
    double value = First ? start(i) : partial[i];
    for (std::size_t c = 0; c < C; ++c) {
      value = combine(value, problem.row[first + c][i] * f[c]);
    }
    if constexpr (Last) {
      finish(i, value);
    } else {
      partial[i] = value;
    }
  }
}

/// All columns: the tool's at once, those of a string two at a time, so that partial results stay
/// in registers. The order of the columns is the same in either case.
template <typename Start, typename Combine, typename Finish>
[[gnu::always_inline]] inline void fold_rows(const QpProblem& problem, const double* factor,
                                             double* partial, Start start, Combine combine,
                                             Finish finish) noexcept {
  const auto unknowns = static_cast<std::size_t>(problem.unknowns);
  if (unknowns == kTool) {
    fold_columns<kTool, true, true>(problem, 0, factor, partial, start, combine, finish);
    return;
  }
  std::size_t k = unknowns < kTool ? 1 : kTool;
  if (unknowns < kTool) {
    fold_columns<1, true, false>(problem, 0, factor, partial, start, combine, finish);
  } else {
    fold_columns<kTool, true, false>(problem, 0, factor, partial, start, combine, finish);
  }
  for (; k + 2 <= unknowns; k += 2) {
    fold_columns<2, false, false>(problem, k, factor, partial, start, combine, finish);
  }
  if (k < unknowns) {
    fold_columns<1, false, false>(problem, k, factor, partial, start, combine, finish);
  }
  fold_columns<0, false, true>(problem, 0, factor, partial, start, combine, finish);
}

[[gnu::always_inline]] inline RowSurvey survey_body(const QpProblem& problem, const double* x,
                                                    double* violation) noexcept {
  Key poison = 0;
  std::int64_t positive = 0;
  const auto start = [&](std::size_t i) { return problem.bound[i]; };
  const auto combine = [](double value, double product) { return value - product; };
  const auto finish = [&](std::size_t i, double value) {
    poison |= poison_of(value);
    positive += value > 0.0 ? 1 : 0;
    violation[i] = value;
  };
  fold_rows(problem, x, violation, start, combine, finish);
  return {poison == 0, static_cast<int>(positive)};
}

[[gnu::always_inline]] inline RowIndex evaluate_most_body(const QpProblem& problem, const double* x,
                                                          const RowMeasure& measure,
                                                          double* violation) noexcept {
  const double* inverse_length = measure.inverse_length.value.data();
  const double threshold = measure.threshold;
  Key best = 0;
  const auto start = [&](std::size_t i) { return problem.bound[i]; };
  const auto combine = [](double value, double product) { return value - product; };
  const auto finish = [&](std::size_t i, double value) {
    const Key key = key_of(value * inverse_length[i], i);
    best = key > best ? key : best;
    violation[i] = value;
  };
  fold_rows(problem, x, violation, start, combine, finish);
  return row_above(best, threshold);
}

[[gnu::always_inline]] inline RowIndex most_body(const double* violation, const RowMeasure& measure,
                                                 std::size_t rows) noexcept {
  const double* inverse_length = measure.inverse_length.value.data();
  Key best = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    const Key key = key_of(violation[i] * inverse_length[i], i);
    best = key > best ? key : best;
  }
  return row_above(best, measure.threshold);
}

/// 1 / sqrt(value) within 4 %, by halving the exponent: no division, no square root (Lomont, "Fast
/// inverse square root", 2003).
[[gnu::always_inline]] inline double approximate_inverse_root(double value) noexcept {
  return std::bit_cast<double>(0x5fe6eb50c7b537a9U - (std::bit_cast<std::uint64_t>(value) >> 1U));
}

[[gnu::always_inline]] inline bool inverse_lengths_body(const QpProblem& problem,
                                                        const double* scale,
                                                        double* inverse_length) noexcept {
  Key poison = 0;
  const auto start = [](std::size_t) { return 0.0; };
  const auto combine = [](double sum, double product) { return sum + product * product; };
  const auto finish = [&](std::size_t i, double sum) {
    poison |= poison_of(sum);
    inverse_length[i] = approximate_inverse_root(sum);
  };
  fold_rows(problem, scale, inverse_length, start, combine, finish);
  return poison == 0;
}

[[gnu::target("avx2")]] RowSurvey survey_avx2(const QpProblem& problem, const double* x,
                                              double* violation) noexcept {
  return survey_body(problem, x, violation);
}

[[gnu::target("avx2")]] RowIndex evaluate_most_avx2(const QpProblem& problem, const double* x,
                                                    const RowMeasure& measure,
                                                    double* violation) noexcept {
  return evaluate_most_body(problem, x, measure, violation);
}

[[gnu::target("avx2")]] RowIndex most_avx2(const double* violation, const RowMeasure& measure,
                                           std::size_t rows) noexcept {
  return most_body(violation, measure, rows);
}

[[gnu::target("avx2")]] bool inverse_lengths_avx2(const QpProblem& problem, const double* scale,
                                                  double* inverse_length) noexcept {
  return inverse_lengths_body(problem, scale, inverse_length);
}

}  // namespace

RowSurvey evaluate_violations(const QpProblem& problem, const double* x,
                              RowValues& violation) noexcept {
  if (avx2_available()) return survey_avx2(problem, x, violation.value.data());
  return survey_body(problem, x, violation.value.data());
}

bool inverse_row_lengths(const QpProblem& problem, const double* scale,
                         RowValues& inverse_length) noexcept {
  if (avx2_available()) return inverse_lengths_avx2(problem, scale, inverse_length.value.data());
  return inverse_lengths_body(problem, scale, inverse_length.value.data());
}

RowIndex most_violated(const RowValues& violation, const RowMeasure& measure,
                       std::size_t rows) noexcept {
  const double* v = violation.value.data();
  if (avx2_available()) return most_avx2(v, measure, rows);
  return most_body(v, measure, rows);
}

RowIndex evaluate_most_violated(const QpProblem& problem, const double* x,
                                const RowMeasure& measure, RowValues& violation) noexcept {
  double* v = violation.value.data();
  if (avx2_available()) return evaluate_most_avx2(problem, x, measure, v);
  return evaluate_most_body(problem, x, measure, v);
}

}  // namespace hapticd
