// Static deflection of a string under a finger (Eq. 10-12), with the exact sine delta / L1 where
// the paper prints sin(delta / L1), and without its cancelling L1 + L2 - L:
//   F(delta) = (T + F_i) (delta/L1 + delta/L2),   F_i = E A ext / L,
//   ext = delta^2 / (L1 + lambda L) + delta^2 / (L2 + (1 - lambda) L).
// F is the gradient of the energy U = T ext + E A ext^2 / (2 L). At an end (lambda 0 or 1) F jumps
// from 0 to T at delta = 0: there the series stiffness kc decides. Deviation: see above. SI. RT:
// yes.
#pragma once

#include "core/instrument/string_parameters.h"
#include "core/math/realtime.h"

namespace hapticd {

/// A string deflected by delta at lambda.
struct Deflection {
  double force;        ///< F, N
  double slope;        ///< dF/ddelta, N/m; may be infinite at delta = 0 on an end
  double secant;       ///< F / delta, N/m; k0 at delta = 0, infinite there on an end
  double energy;       ///< U, J
  double axial_force;  ///< F_i, N
  /// Force of the string on the finger along the axis from A to B, N: (T + F_i) (cos theta_2 - cos
  /// theta_1), the frictionless balance of its two halves; it points to the middle.
  double lateral_force;
};

/// All of it. delta in [0, 1e100] m, lambda in [0, 1]; a string of length 0 gives zeros. Relative
/// error <= 2e-15 of each; 21 ns.
[[nodiscard]] HD_REALTIME Deflection deflect(const StringConstants& string, double lambda,
                                             double delta) noexcept;

/// F(delta) alone, N, the same bits; 10 ns.
[[nodiscard]] HD_REALTIME double deflection_force(const StringConstants& string, double lambda,
                                                  double delta) noexcept;

/// k0 = T / (L lambda (1 - lambda)), N/m; infinite on the ends (0 when slack).
[[nodiscard]] HD_REALTIME double small_deflection_stiffness(const StringConstants& string,
                                                            double lambda) noexcept;

/// The string in series with a spring: where a total displacement D goes.
struct SeriesDeflection {
  double delta;  ///< of the string, m, in [0, D]
  double force;  ///< kc (D - delta) = F(delta), N (on an end with kc D < T: delta 0, force kc D)
};

/// Solves F(delta) = kc (D - delta) by bracketed Newton iterations; D in [0, 1e100] m (below 1e-80
/// it counts as 0), kc in [1e-3, 1e9] N/m. Error of force <= 2e-15 of itself, of delta <= 2e-15 of
/// D. A string of length 0 does not yield. 0.1 us, next to an end 0.3 us.
[[nodiscard]] HD_REALTIME SeriesDeflection deflect_in_series(const StringConstants& string,
                                                             double lambda, double displacement,
                                                             double stiffness) noexcept;

/// Pitch of a string let go at lambda, swinging there with amplitude `delta` (m), over its tuning:
/// sqrt(1 + F_i / (2 T) (1 + s / 2)), F_i of that triangle; s, the fundamental's share of it, is
/// 2 sin^2(pi lambda) / (pi^2 lambda (1 - lambda)). 1 when slack. lambda in [0, 1]. 30 ns.
[[nodiscard]] HD_REALTIME double pitch_factor(const StringConstants& string, double lambda,
                                              double delta) noexcept;

}  // namespace hapticd
