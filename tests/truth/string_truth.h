// What a plucked string does under a finger, computed offline as well as we can: the truth for the
// models of core/instrument, of which it shares no code. Two methods that share nothing either:
// some hundred modes as two-term recurrences, driven by the finger at every sample, and the wave
// equation on a grid with c h = dx, where finite differences are d'Alembert's solution (J. O.
// Smith, "Physical Audio Signal Processing", 2010). The finger is a massless one-sided spring,
// whose far end the hand moves. SI. Not RT.
#pragma once

#include <vector>

namespace hapticd {

struct TruthString {
  double length = 1.1;
  double tension = 30.0;
  double frequency = 65.4;    ///< f_1, Hz
  double decay = 0.5;         ///< of the amplitude until the finger comes, s; infinity is allowed
  double touch_decay = 0.03;  ///< from then on, s
};

/// Drawn aside at a point, let go at once, later pressed at another point.
struct TruthPress {
  double pluck_lambda = 0.1;
  double pluck_delta = 5e-3;  ///< m
  double free_time = 0.05;    ///< from pluck to the start of the touch, s
  double lambda = 0.3;        ///< of the finger
  double stiffness = 1000.0;  ///< of the finger, N/m
  double start_D = -6e-3;     ///< where the hand is when the touch starts, m
  double end_D = 2e-3;        ///< and where it stays, m
  double ramp_time = 0.04;    ///< in between, s, without jerks at its ends
  int ticks = 100;            ///< of 1 ms, from the start of the touch

  /// D at `time` (s) from the start of the touch, m: minimum-jerk ramp (Flash and Hogan, 1985).
  [[nodiscard]] double hand(double time) const;
};

struct TruthRun {
  std::vector<double> force;   ///< mean over each tick, N
  double work = 0.0;           ///< of the hand, J
  double energy_before = 0.0;  ///< of the string at the start of the touch, J
  double energy = 0.0;         ///< of string and finger spring at the end, J
};

/// `modes` modes, `rate` samples per second, a multiple of 1000. Under the finger a mode obeys
/// m (q'' + 2 q'/T_d + omega^2 q) = F phi; modes beyond the last follow at once, as a spring in
/// series.
TruthRun play_modes(const TruthString& string, const TruthPress& press, int modes, int rate);

/// `cells` cells, both lambdas multiples of 1/cells: w_tt + 2 w_t / T_d = c^2 w_xx + F / mu.
TruthRun play_grid(const TruthString& string, const TruthPress& press, int cells);

/// The free shape itself, to judge plucks: displacement at `lambda`, `time` after the string was
/// let go, by d'Alembert's reflected waves. Undamped.
double free_displacement(const TruthString& string, double pluck_lambda, double pluck_delta,
                         double lambda, double time);

}  // namespace hapticd
