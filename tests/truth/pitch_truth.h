// The pitch of a plucked string that tightens as it swings, computed offline: the truth for the
// pitch of core/instrument, of which it shares no code. Kirchhoff's string (G. F. Carrier, "On the
// non-linear vibration problem of the elastic string", Q. Appl. Math. 3, 1945), in one plane: all
// modes share one tension, T + E A / (4 L^2) sum (n pi q_n)^2. SI. Not RT.
#pragma once

namespace hapticd {

/// A string and how it is drawn aside before it is let go.
struct GlidingString {
  double length = 1.1;             ///< m
  double tension = 30.0;           ///< at rest, N
  double axial_stiffness = 0.0;    ///< E A, N
  double frequency = 65.4;         ///< f_1 at rest, Hz
  double decay = 0.5;              ///< of the amplitude, s
  double pluck_lambda = 0.5;       ///< in (0, 1)
  double pluck_deflection = 5e-3;  ///< m
};

/// Mean frequency of the fundamental in the first `seconds` after it was let go, Hz: turns of
/// (q_1, dq_1/dt) over time. `modes` modes, `rate` steps of leapfrog per second, so many that the
/// highest mode has a dozen of them at least.
[[nodiscard]] double mean_frequency(const GlidingString& string, double seconds, int modes,
                                    int rate);

}  // namespace hapticd
