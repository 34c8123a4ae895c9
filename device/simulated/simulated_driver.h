// The driver of the simulated device. Not RT.
#pragma once

#include "device/api/driver.h"

namespace hapticd {

/// A SimulatedDevice held by the arm of `options`.
[[nodiscard]] OpenDevice make_simulated(const DeviceSheet& sheet, const InsideOptions& options);

inline constexpr DriverEntry kSimulatedDriver{.kind = "simulated",
                                              .driver = DeviceDriver::kSimulated,
                                              .what = "device and hand, computed",
                                              .profile = "premium_3_0_6dof",
                                              .traits = {.can_push_a_person = false},
                                              .plays_gestures = true,
                                              .make = make_simulated};

}  // namespace hapticd
