// A two-axis force device of the HID PID class: told by its report descriptor, given the profile
// that is for its maker's numbers, limited to what a device without a watchdog may be given. Not
// RT.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "device/pid/pid_layout.h"
#include "server/devices/outside_device.h"

namespace hapticd {

/// Force of a device that pushes on when nobody tells it anything any more, N.
inline constexpr double kUnwatchedForce = 1.0;

/// The profile of devices that no other profile is for.
inline constexpr const char* kGenericPid = "pid";

/// Its reports carry what the driver needs, and it is not of the HID profile.
[[nodiscard]] bool is_pid(const HidrawNode& node);

/// The one of `installed` for this device, of several that with most numbers; `base` where none is,
/// or where a profile was chosen by name.
[[nodiscard]] v1::DeviceProfile pid_base(const HidrawNode& node, const v1::DeviceProfile& base,
                                         std::span<const v1::DeviceProfile> installed);

/// `base` with the limits of a device that has no watchdog. Throws DeviceError that says what to
/// write into a profile where `base` does not tell what a unit of position and force is.
[[nodiscard]] v1::DeviceProfile pid_profile(const HidrawNode& node, const pid::PidLayout& layout,
                                            const v1::DeviceProfile& base);

/// Nodes in /dev through which the kernel's own driver lets other programs push with it.
[[nodiscard]] std::vector<std::string> force_inputs(const HidrawNode& node,
                                                    const std::string& sys = "/sys");

/// As attach_device.
[[nodiscard]] OutsideDevice attach_pid(const std::string& serial, const v1::DeviceProfile& base,
                                       double max_force, const std::filesystem::path& checks);

}  // namespace hapticd
