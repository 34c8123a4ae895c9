// The quadratic program of one sub-step of the configuration optimisation (Eq. 5-7, linearised):
//   minimise 1/2 sum_k weight_k (x_k - target_k)^2   subject to   sum_k row[k][i] x_k >= bound[i],
//   i = 0 .. rows-1.
// Unknowns: [linear; angular] step of the graphic tool (m, rad), then two deflections per
// deflecting string (m). Rows are stored by column (structure of arrays) so that all rows are
// evaluated at once. RT: yes, fixed size, 0.3 MB.
#pragma once

#include <array>
#include <cstdint>

#include "core/math/limits.h"

namespace hapticd {

struct QpProblem {
  int unknowns = kToolDof;  ///< 1 .. kMaxQpUnknowns
  int rows = 0;             ///< 0 .. kMaxQpRows
  /// Diagonal of the Hessian, > 0 and finite (N/m, N m/rad, N/m).
  std::array<double, kMaxQpUnknowns> weight;
  /// Unconstrained minimiser (m, rad, m).
  std::array<double, kMaxQpUnknowns> target;
  /// row[k][i]: coefficient of unknown k in row i. Every row may have its own scale, with a length
  /// in the scaled space (row_k / weight_k^1/2) from 1e-140 to 1e150. A shorter row counts as zero,
  /// which is legal, and feasible when its bound <= 0.
  alignas(64) std::array<std::array<double, kMaxQpRows>, kMaxQpUnknowns> row;
  /// Right-hand sides, finite.
  alignas(64) std::array<double, kMaxQpRows> bound;
};

enum class QpStatus : std::uint8_t {
  kOptimal,
  /// Rows contradict each other (beyond rounding of the scaled data); x is the last iterate, NOT to
  /// be used.
  kInfeasible,
  /// Iteration bound hit; x is NOT feasible (a dual method's iterates are not until the last).
  kIterationLimit,
  /// Non-finite data, data so large that scaled quantities overflow, or a weight <= 0; nothing else
  /// in the solution means anything.
  kInvalid,
};

struct QpSolution {
  QpStatus status = QpStatus::kInvalid;
  std::array<double, kMaxQpUnknowns> x;
  /// Active rows and their multipliers (>= 0, in units of the objective per unit of the row as
  /// given): weight (x - target) = sum multiplier_i row_i. Linearly independent rows, at most
  /// `unknowns`; of redundant rows one representative.
  int active_count = 0;
  std::array<std::int16_t, kMaxQpUnknowns> active;
  std::array<double, kMaxQpUnknowns> multiplier;
  int iterations = 0;
  /// Row that proved infeasibility, or -1.
  int infeasible_row = -1;
};

/// Rows guessed active (typically those active in the previous sub-step), any order, duplicates and
/// dependent rows tolerated.
struct QpWarmStart {
  int count = 0;
  std::array<std::int16_t, kMaxQpUnknowns> active;
};

}  // namespace hapticd
