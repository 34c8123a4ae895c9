// The last correction of a solution: x = target + step carries the rounding of the target, which
// may be large beside x, and which a sharp wedge of active rows amplifies. One step of iterative
// refinement on the rows as given removes it; where the wedge is sharp, with residuals in twice the
// precision (Dekker, "A floating-point technique for extending the available precision", Numerische
// Mathematik 18, 1971; Ogita, Rump, Oishi, "Accurate sum and dot product", SIAM J. Sci. Comput. 26,
// 2005). RT: yes; O(unknowns * active rows).
#pragma once

#include <array>
#include <cstddef>

#include "core/solver/active_set.h"

namespace hapticd {

/// Sharpness (no unit) beyond which residuals are computed in twice the precision. Normal: 1 to 30.
/// Larger: wedges sharper than its inverse lose digits. Smaller: costs time.
inline constexpr double kQpSharpWedge = 1e3;

/// sum + error -= a b without rounding; |a|, |b| < 1e300.
inline void subtract_product(double a, double b, double& sum, double& error) noexcept {
  constexpr double kSplit = 0x1p27 + 1.0;
  const double a_high = kSplit * a - (kSplit * a - a);
  const double b_high = kSplit * b - (kSplit * b - b);
  const double a_low = a - a_high;
  const double b_low = b - b_high;
  const double product = a * b;
  const double product_error =
      ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
  const double next = sum - product;
  const double change = next - sum;
  error += (sum - (next - change)) - (product + change) - product_error;
  sum = next;
}

/// bound - row . x of one row, as if computed in twice the precision.
[[nodiscard]] inline double exact_violation(const QpProblem& problem, std::size_t unknowns,
                                            std::size_t row,
                                            const std::array<double, kMaxQpUnknowns>& x) noexcept {
  double sum = problem.bound[row];
  double error = 0.0;
  for (std::size_t k = 0; k < unknowns; ++k) {
    subtract_product(problem.row[k][row], x[k], sum, error);
  }
  return sum + error;
}

/// Makes the multipliers balance z - z_target as exactly as they can be stored.
template <std::size_t P>
inline void refine_multipliers(ActiveFactor& factor) noexcept {
  LaneVector imbalance;
  copy<P>(factor.step, imbalance);
  for (std::size_t j = 0; j < factor.count; ++j) {
    add_scaled<P>(imbalance, -factor.multiplier[j], factor.row[j].normal);
  }
  for (std::size_t j = 0; j < factor.count; ++j) {
    add_scaled<P>(factor.multiplier, dot<P>(factor.q[j], imbalance), factor.inverse[j]);
  }
}

/// Moves x, and the multipliers with it, onto the active planes as exactly as x can be stored.
/// workspace.violation holds the violations at x.
template <std::size_t P>
inline void refine_point(const QpProblem& problem, std::size_t unknowns, QpWorkspace& workspace,
                         std::array<double, kMaxQpUnknowns>& x) noexcept {
  ActiveFactor& factor = workspace.factor;
  const bool sharp = factor.sharpness > kQpSharpWedge;
  LaneVector lacking;
  set_zero<P>(lacking);
  for (std::size_t j = 0; j < factor.count; ++j) {
    const std::size_t row = factor.row[j].index;
    const double lack =
        sharp ? exact_violation(problem, unknowns, row, x) : workspace.violation.value[row];
    lacking.set(j, lack * factor.row[j].scale);
  }
  LaneVector correction;
  set_zero<P>(correction);
  for (std::size_t j = 0; j < factor.count; ++j) {
    const double coordinate = dot<P>(factor.inverse[j], lacking);
    add_scaled<P>(correction, coordinate, factor.q[j]);
    add_scaled<P>(factor.multiplier, coordinate, factor.inverse[j]);
  }
  for (std::size_t k = 0; k < unknowns; ++k)
    x[k] += correction[k] * workspace.inverse_root_weight[k];
  if (sharp) {
    add_scaled<P>(factor.step, 1.0, correction);
    refine_multipliers<P>(factor);
  }
}

}  // namespace hapticd
