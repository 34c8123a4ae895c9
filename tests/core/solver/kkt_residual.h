// How far a QpSolution is from the optimum: the largest scaled violation of the Karush-Kuhn-Tucker
// conditions. Independent of the solver's own factors. One pass over all rows, no heap.
#pragma once

#include "core/solver/qp_problem.h"

namespace hapticd {

/// Largest of the four below, in the scaled space z = weight^1/2 x with rows of unit length, where
/// s = max(|z|, |z_target|). Dimensionless; infinite when the active set is malformed or a number
/// is not finite. The status of the solution is not looked at.
///   stationarity     |z - z_target - sum multiplier_i row_i| / max(s, sum |multiplier_i|)
///   primal           violation_i / max(s, |bound_i|)
///   dual             -multiplier_i / s
///   complementarity  min(multiplier_i, slack_i) / s
/// The sum of multipliers counts because rows that nearly oppose each other need huge ones, and no
/// x in double precision balances them better.
[[nodiscard]] double kkt_residual(const QpProblem& problem, const QpSolution& solution) noexcept;

}  // namespace hapticd
