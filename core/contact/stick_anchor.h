// Coulomb friction as a spring between the material points of tool and object that yields at mu N:
// it sticks where it holds, and slips where it would bear more (return mapping: J. C. Simo and
// T. J. R. Hughes, "Computational Inelasticity", 1.2). While it sticks nothing moves it but the
// motion of the points, so what is held does not creep. SI, frame W. RT: yes, a few ns.
#pragma once

#include "core/math/vector.h"

namespace hapticd {

/// What one anchor is: `stiffness` of its spring, N/m, > 0; `limit` = mu N, what it bears, N, >= 0.
struct StickAnchor {
  double stiffness;
  double limit;

  /// Stiffness at a slip of `slip` m: the spring's own while it sticks, what leads to mu N while it
  /// slips; 0 where there is no friction.
  [[nodiscard]] double stiffness_at(double slip) const noexcept {
    if (!(limit > 0.0)) return 0.0;
    return stiffness * slip <= limit ? stiffness : limit / slip;
  }
  /// Direction in which it slips at `slip_W`, unit, where the force does not change; zero where it
  /// sticks.
  [[nodiscard]] Vector3 slipping(const Vector3& slip_W) const noexcept {
    const double slip = slip_W.norm();
    return stiffness * slip > limit ? Vector3(slip_W / slip) : Vector3(0.0, 0.0, 0.0);
  }
  /// Force on the tool that has slipped by `slip_W`, tangential, N.
  [[nodiscard]] Vector3 force(const Vector3& slip_W) const noexcept {
    return -stiffness_at(slip_W.norm()) * slip_W;
  }
  /// Energy at a slip of `slip` m, J: quadratic while it sticks, linear beyond (Huber's function).
  [[nodiscard]] double energy(double slip) const noexcept {
    const double force = stiffness * slip;
    return force <= limit ? 0.5 * force * slip : limit * (slip - 0.5 * limit / stiffness);
  }
  /// The slip that is left at the end of a tick: what the spring exceeds mu N by is heat.
  [[nodiscard]] Vector3 left_of(const Vector3& slip_W) const noexcept {
    const double longest = limit / stiffness;
    const double slip = slip_W.norm();
    return slip > longest ? Vector3(slip_W * (longest / slip)) : slip_W;
  }
};

}  // namespace hapticd
