// See device_limits.h.
#include "server/haptic_loop/device_limits.h"

#include <algorithm>
#include <cmath>

namespace hapticd {

StiffnessLimits stiffness_limits_of(const DeviceProfile& profile, const DriverTraits& driver,
                                    double period_s) {
  StiffnessLimits limits;
  limits.damping = profile.damping;
  // What gives no torque renders no rotational stiffness, whatever its damping.
  const Array3& damping = profile.rotational_damping;
  const bool turns = profile.peak_torque > 0.0;
  limits.rotational_damping = turns ? *std::min_element(damping.begin(), damping.end()) : 0.0;
  if (std::isfinite(profile.stiffness_max) && profile.stiffness_max > 0.0) {
    limits.stiffness_max = profile.stiffness_max;
  }
  limits.period_s = period_s;
  const bool known = profile.delay > 0.0 || !driver.has_no_clock;
  limits.delay_s = known ? profile.delay : kUnmeasuredDelay_s;
  return limits;
}

}  // namespace hapticd
