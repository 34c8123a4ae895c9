// The string as the paper prints it (Eq. 9-13), to be compared with core/instrument, which departs
// from it where it says so. Along the touch normal. SI. Not RT.
#pragma once

#include "core/instrument/energy_tank.h"
#include "core/instrument/string_parameters.h"

namespace hapticd {

/// Eq. 10-12 with the printed sin(delta / L1) and L1 + L2 - L.
struct PrintedDeflection {
  double L1 = 0.0;       ///< m
  double L2 = 0.0;       ///< m
  double F_i = 0.0;      ///< N
  double force = 0.0;    ///< |F_r|, N; 0 where delta is
  double theta_1 = 0.0;  ///< atan(delta / (lambda L)), rad: the angle of the force triangle
  double theta_2 = 0.0;
};

/// A string deflected by delta >= 0 at lambda, which may lie a margin outside [0, 1].
[[nodiscard]] PrintedDeflection printed_deflection(const StringConstants& string, double lambda,
                                                   double delta);

/// What is left open of Eq. 9, and chosen here.
struct PrintedVibrationOptions {
  /// F_v is bounded by an energy tank, as ours is; the paper has none.
  bool tank = false;
};

/// A string that rings as Eq. 9 says. Between a release and the next, r_max is the largest delta of
/// the touch before, k_v is T / (L lambda (1 - lambda)) at its last lambda, and t counts from the
/// release; T_d is the string's own, in touch too.
class PrintedVibration {
 public:
  /// One tick later. `delta` of the touch in m, less than 0: not touched; `lambda` of the touch.
  void advance(const StringConstants& string, double delta, double lambda, double dt_s);

  /// r_max exp(-t / T_d): what the cylinder grows by, m; 0 before the first release.
  [[nodiscard]] double radius(const StringConstants& string) const;

  /// F_v on the tool along the touch normal, N. `moved` (m) is the hand's way along it since the
  /// last tick, away from the string. Once per tick in which it is touched.
  [[nodiscard]] double force(const StringConstants& string, const PrintedVibrationOptions& options,
                             double moved, double dt_s);

  /// E of what rings, J: pi^2 T r^2 / (4 L).
  [[nodiscard]] double energy(const StringConstants& string) const;

 private:
  double r_max_ = 0.0;      ///< m
  double since_s_ = 0.0;    ///< since the release
  double k_v_ = 0.0;        ///< N/m
  double delta_max_ = 0.0;  ///< of the touch under way, m
  double lambda_ = 0.5;
  bool touched_ = false;
  EnergyTank tank_;
};

}  // namespace hapticd
