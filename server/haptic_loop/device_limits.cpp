// See device_limits.h.
#include "server/haptic_loop/device_limits.h"

#include <algorithm>
#include <cmath>

#include "core/safety/passivity.h"

namespace hapticd {

PortDamping port_damping_of(const DeviceProfile& profile, const DriverTraits& driver) {
  const bool is_felt = reaches_a_hand(profile, driver);
  PortDamping damping;
  if (!is_felt || !profile.damping_guessed) damping.translational = profile.damping;
  if (!is_felt || !profile.rotational_damping_guessed) {
    const Array3& axes = profile.rotational_damping;
    damping.rotational = *std::min_element(axes.begin(), axes.end());
  }
  return damping;
}

int flight_of(const StiffnessLimits& limits) noexcept {
  const bool unknown = limits.delay_unknown && !(limits.delay_s > 0.0);
  if (limits.damping_guessed || unknown) return kMostFlight;
  // A delay of whole ticks is that many, whatever its last bits.
  const double ticks = std::ceil(limits.delay_s / limits.period_s - 1e-6);
  return static_cast<int>(std::clamp(ticks, 0.0, static_cast<double>(kMostFlight)));
}

StiffnessLimits stiffness_limits_of(const DeviceProfile& profile, const DriverTraits& driver,
                                    double period_s) {
  StiffnessLimits limits;
  limits.damping = profile.damping;
  limits.damping_guessed = profile.damping_guessed && reaches_a_hand(profile, driver);
  limits.report_interval_s = 1e-9 * static_cast<double>(report_interval_ns(profile));
  // What gives no torque renders no rotational stiffness, whatever its damping.
  const Array3& damping = profile.rotational_damping;
  // Of a client's own device a number that nobody has stated bounds nothing.
  const bool told = !driver.follows_data || !profile.rotational_damping_guessed;
  const bool turns = profile.peak_torque > 0.0 && told;
  limits.rotational_damping = turns ? *std::min_element(damping.begin(), damping.end()) : 0.0;
  if (std::isfinite(profile.stiffness_max) && profile.stiffness_max > 0.0) {
    limits.stiffness_max = profile.stiffness_max;
  }
  limits.period_s = period_s;
  const bool known = profile.delay > 0.0 || !driver.has_no_clock;
  limits.delay_s = known ? profile.delay : kUnmeasuredDelay_s;
  limits.delay_unknown = !(profile.delay > 0.0) && reaches_a_hand(profile, driver);
  return limits;
}

}  // namespace hapticd
