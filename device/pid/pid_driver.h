// The driver of two-axis force devices of the HID PID class: told by their report descriptor, given
// the profile that is for their maker's numbers, limited to what a device without a watchdog may be
// given. Not RT.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "device/api/driver.h"
#include "device/pid/pid_layout.h"

namespace hapticd::pid {

/// Most force for a device that keeps pushing when nobody commands it any more, N.
inline constexpr double kUnwatchedForce = 1.0;

/// Its reports carry what the driver needs.
[[nodiscard]] bool is_mine(const HidrawNode& node);

/// The one of `installed` for this device, of several that with most numbers; `chosen` where none
/// is, or where `chosen` is not the one of every such device, but named.
[[nodiscard]] DeviceSheet matching_sheet(const HidrawNode& node, const DeviceSheet& chosen,
                                         std::span<const DeviceSheet> installed);

/// `chosen` with the limits of a device that has no watchdog. Throws DeviceError that says what to
/// write into a profile where `chosen` does not tell what a unit of position and force is.
[[nodiscard]] DeviceSheet unwatched_sheet(const HidrawNode& node, const PidLayout& layout,
                                          const DeviceSheet& chosen);

/// Nodes in /dev through which the kernel's own driver lets other programs push with it.
[[nodiscard]] std::vector<std::string> force_inputs(const HidrawNode& node,
                                                    const std::string& sys = "/sys");

[[nodiscard]] OpenDevice open(const FoundDevice& found);

inline constexpr DriverEntry kDriver{.kind = "pid",
                                     .driver = DeviceDriver::kPid,
                                     .what = "two-axis force device, experimental, no watchdog",
                                     .argument = SourceArgument::kSerial,
                                     .profile = "pid",
                                     .traits = {.has_no_clock = true},
                                     .mine = is_mine,
                                     .open = open};

}  // namespace hapticd::pid
