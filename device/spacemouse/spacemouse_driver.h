// The driver of SpaceMouse devices. Not RT.
#pragma once

#include "device/api/driver.h"

namespace hapticd::spacemouse {

/// Its descriptor has a multi-axis controller, or its vendor and product are those of the family.
[[nodiscard]] bool is_mine(const HidrawNode& node);

/// Pushes nobody: its profile holds as it is.
[[nodiscard]] OpenDevice open(const FoundDevice& found);

inline constexpr DriverEntry kDriver{.kind = "spacemouse",
                                     .driver = DeviceDriver::kSpacemouse,
                                     .what = "moves a tool, without force",
                                     .argument = SourceArgument::kSerial,
                                     .profile = "spacemouse",
                                     .traits = {.can_push_a_person = false},
                                     .mine = is_mine,
                                     .open = open};

}  // namespace hapticd::spacemouse
