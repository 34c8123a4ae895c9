// The driver of the scripted device. Not RT.
#pragma once

#include "device/api/driver.h"

namespace hapticd {

/// A ScriptedDevice; in virtual time a tick without a pose holds the last one.
[[nodiscard]] OpenDevice make_scripted(const DeviceSheet& sheet, const InsideOptions& options);

inline constexpr DriverEntry kScriptedDriver{
    .kind = "scripted",
    .driver = DeviceDriver::kScripted,
    .what = "poses of a client",
    .profile = "premium_3_0_6dof",
    .traits = {.can_push_a_person = false, .follows_data = true},
    .takes_poses = true,
    .make = make_scripted};

}  // namespace hapticd
