// The loops over all rows of a QpProblem: one multiply-add per coefficient and a search. They are
// the cost of a warm solve with many rows, so each exists for the baseline and for AVX2, chosen by
// core/math/cpu.h, with equal bits: the lanes are rows, and the sum of a row has one order.
// Only the first `rows` entries are read and written. RT: yes, O(rows * unknowns).
#pragma once

#include <array>
#include <cstddef>

#include "core/math/limits.h"
#include "core/math/realtime.h"
#include "core/solver/qp_problem.h"

namespace hapticd {

/// One value per row.
struct alignas(64) RowValues {
  std::array<double, kMaxQpRows> value;
};

struct RowSurvey {
  bool finite;   ///< all are; where not, the data are not or they overflow
  int positive;  ///< how many are > 0
};

/// A row, or kMaxQpRows: none.
using RowIndex = std::size_t;

/// violation = bound - row . x of every row, and what they are like.
HD_REALTIME RowSurvey evaluate_violations(const QpProblem& problem, const double* x,
                                          RowValues& violation) noexcept;

/// 1 / |row_k scale_k| of every row within 4 %, which is enough to compare violations; 1e154 for a
/// row of zeros. False when the square of a length is not finite.
[[nodiscard]] HD_REALTIME bool inverse_row_lengths(const QpProblem& problem, const double* scale,
                                                   RowValues& inverse_length) noexcept;

/// How violations are compared: by violation * inverse_length, those above `threshold` >= 0.
struct RowMeasure {
  const RowValues& inverse_length;
  double threshold;
};

/// The most violated row, or kMaxQpRows: none. Measures that agree in all but their last eight bits
/// are equal, and the lowest row wins.
[[nodiscard]] HD_REALTIME RowIndex most_violated(const RowValues& violation,
                                                 const RowMeasure& measure,
                                                 std::size_t rows) noexcept;

/// evaluate_violations without counts, and most_violated, in one pass.
[[nodiscard]] HD_REALTIME RowIndex evaluate_most_violated(const QpProblem& problem, const double* x,
                                                          const RowMeasure& measure,
                                                          RowValues& violation) noexcept;

}  // namespace hapticd
