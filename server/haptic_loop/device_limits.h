// What the profile of a device says of the stiffness that it bears. Not RT.
#pragma once

#include "core/safety/stiffness_clamp.h"
#include "device/api/device_profile.h"

namespace hapticd {

/// Delay of a device without a clock whose profile states none, s: a frame in, a frame for each of
/// two axes out. Nothing ever measures it, and none would make it bear several times the stiffness.
inline constexpr double kUnmeasuredDelay_s = 3e-3;

/// In a loop of this period. The coupling's damping is that of the settings.
[[nodiscard]] StiffnessLimits stiffness_limits_of(const DeviceProfile& profile,
                                                  const DriverTraits& driver, double period_s);

}  // namespace hapticd
