// What the profile of a device says of the stiffness that it bears, and of the energy that it
// takes. Not RT but where it is said.
#pragma once

#include "core/math/realtime.h"
#include "core/safety/stiffness_clamp.h"
#include "device/api/device_profile.h"

namespace hapticd {

/// Delay of a device without a clock whose profile states none, s: a frame in, a frame for each of
/// two axes out. Nothing ever measures it, and none would make it bear several times the stiffness.
inline constexpr double kUnmeasuredDelay_s = 3e-3;

/// Whether the hand feels the force that the device is told to give: it has motors, or the client
/// that gives its poses has.
[[nodiscard]] constexpr bool reaches_a_hand(const DeviceProfile& profile,
                                            const DriverTraits& driver) noexcept {
  return driver.can_push_a_person || (driver.follows_data && profile.force_reaches_hand);
}

/// What of the device repays energy at the port. A guess is none where a hand feels the force; the
/// simulated device has what its profile says.
struct PortDamping {
  double translational = 0.0;  ///< N s/m
  double rotational = 0.0;     ///< N m s/rad
};

[[nodiscard]] PortDamping port_damping_of(const DeviceProfile& profile, const DriverTraits& driver);

/// Ticks by which a wrench may reach the hand late: the delay, rounded up; kMostFlight where nobody
/// measured it, or the damping. RT: yes.
[[nodiscard]] HD_REALTIME int flight_of(const StiffnessLimits& limits) noexcept;

/// In a loop of this period. The coupling's damping is that of the settings.
[[nodiscard]] StiffnessLimits stiffness_limits_of(const DeviceProfile& profile,
                                                  const DriverTraits& driver, double period_s);

}  // namespace hapticd
