// Exact solver of QpProblem: dual active set on the projection form (z = weight^1/2 x turns the
// program into the projection of a point onto a polyhedron), after Goldfarb and Idnani, "A
// numerically stable dual method for solving strictly convex quadratic programs", Mathematical
// Programming 27 (1983). Warm-started, fixed size, deterministic (ties by lowest row).
// RT: yes; iterations <= kQpIterationsPerRow * rows + unknowns.
#pragma once

#include <array>

#include "core/math/limits.h"
#include "core/math/realtime.h"
#include "core/solver/active_factor.h"
#include "core/solver/lane_vector.h"
#include "core/solver/qp_problem.h"
#include "core/solver/row_scan.h"

namespace hapticd {

/// Bound of the iterations, each of which adds or removes one active row. Normal: 1 to 2 per row
/// of the final active set. Larger only lengthens the worst case.
inline constexpr int kQpIterationsPerRow = 3;

/// Scratch memory of the solver; contents mean nothing between calls.
struct QpWorkspace {
  RowValues violation;
  RowValues inverse_length;
  bool lengths_known;  ///< inverse_length is filled
  bool rows_ignored;   ///< some of its entries are 0: rows that lack no more than rounding
  LaneVector target;   ///< z_target
  std::array<double, kMaxQpUnknowns> inverse_root_weight;
  double target_size;  ///< largest entry of |z_target|
  ActiveFactor factor;
  UnitRow candidate;      ///< the row about to become active,
  SplitRow split;         ///< its split,
  LaneVector multiplier;  ///< and the multipliers on the way there
};

/// Solves `problem` into `solution`; `warm` may be any guess and only saves time. Scaled KKT
/// residual (kkt_residual.h) <= 1e-9 when kOptimal, normally 1e-15; kInfeasible when rows that
/// could hold together contradict each other by more than 1e-10 of |z_target|. Reads only the
/// entries that `unknowns`, `rows` and `count` cover. Without active rows x is the target, bit by
/// bit. Cost warm: 0.3 us with 16 rows, 0.9 us with 256 (6 unknowns, 3 active rows, x86-64 of
/// 2019).
HD_REALTIME void solve_qp(const QpProblem& problem, const QpWarmStart& warm, QpWorkspace& workspace,
                          QpSolution& solution) noexcept;

}  // namespace hapticd
