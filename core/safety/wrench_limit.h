// Last bound on what a device is asked for: force and torque are each shortened to their limit
// along their own direction, so a saturated push still points the right way. Anything non-finite
// becomes zero. RT: yes, about 5 ns.
#pragma once

#include "core/math/realtime.h"
#include "core/math/wrench.h"

namespace hapticd {

/// Peak output of the device (profile data; the defaults are the simulated device's).
struct WrenchLimits {
  double force = 22.0;    ///< N, >= 0
  double torque = 0.515;  ///< N m, >= 0
};

/// `F` with |f| <= limits.force and |t| <= limits.torque; the zero wrench when any component is not
/// finite.
[[nodiscard]] HD_REALTIME Wrench limited(const Wrench& F, const WrenchLimits& limits) noexcept;

}  // namespace hapticd
