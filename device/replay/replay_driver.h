// The driver of the replayed device. Not RT.
#pragma once

#include "device/api/driver.h"

namespace hapticd {

/// A ReplayDevice, which the loop treats as one of `options.recorded`.
[[nodiscard]] OpenDevice make_replay(const DeviceSheet& sheet, const InsideOptions& options);

inline constexpr DriverEntry kReplayDriver{
    .kind = "replay",
    .driver = DeviceDriver::kReplay,
    .what = "a recording",
    .argument = SourceArgument::kFile,
    .profile = "premium_3_0_6dof",
    .traits = {.can_push_a_person = false, .follows_data = true},
    .make = make_replay};

}  // namespace hapticd
