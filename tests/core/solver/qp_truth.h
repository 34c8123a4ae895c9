// Independent truths for tests of the solver, in long double: the Karush-Kuhn-Tucker conditions of
// a solution, and the optimum found by trying every set of active rows. They share no code with
// core/solver. Not RT.
#pragma once

#include <array>

#include "core/solver/qp_problem.h"

namespace hapticd::test {

using LongVector = std::array<long double, kMaxQpUnknowns>;

/// Largest violation of each condition in the scaled space (z = weight^1/2 x, rows of unit length),
/// relative to the larger of |z| and |z_target|; stationarity also to the sum of multipliers,
/// primal also to the bound.
struct KktViolations {
  long double stationarity = 0.0L;
  long double primal = 0.0L;
  long double dual = 0.0L;
  long double complementarity = 0.0L;
  bool well_formed = true;  ///< active rows exist, differ, and are at most `unknowns`

  /// The largest; infinite when malformed.
  [[nodiscard]] long double worst() const;
};

KktViolations kkt_violations(const QpProblem& problem, const QpSolution& solution);

struct ExhaustiveOptimum {
  bool feasible = false;
  LongVector x{};
};

/// The best feasible point among the projections of the target onto every set of at most `unknowns`
/// rows held with equality. Cost: 2^rows small linear systems; rows <= 16.
ExhaustiveOptimum exhaustive_optimum(const QpProblem& problem);

/// Largest difference of two points in the scaled space, relative to the larger of |z_target| and
/// |z|, maximum norms.
long double scaled_difference(const QpProblem& problem, const QpSolution& a, const QpSolution& b);

}  // namespace hapticd::test
