// hapticd device list: the devices plugged into this machine that hapticd can drive. Needs neither
// permission for them nor a running daemon: no device is opened. Not RT.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "device/api/device_profile.h"
#include "device/report_io/hidraw_nodes.h"

namespace hapticd {

/// Exit codes of the list.
inline constexpr int kListGood = 0;
inline constexpr int kListForbidden = 1;  ///< this user may not open one of the devices
inline constexpr int kListUsage = 2;      ///< the command line makes no sense

/// One device that a driver is for.
struct ListedDevice {
  HidrawNode node;
  DeviceDriver driver = DeviceDriver::kHid;
  std::string choice;  ///< what --device takes for it; without serial if it has none
};

/// Those of `nodes` that hapticd has a driver for.
[[nodiscard]] std::vector<ListedDevice> drivable(std::span<const HidrawNode> nodes);

/// For people, remedies included; lines end in a newline.
[[nodiscard]] std::string list_text(std::span<const ListedDevice> devices);

/// For programs: one JSON object and a newline.
[[nodiscard]] std::string list_json(std::span<const ListedDevice> devices);

/// What the list comes to.
[[nodiscard]] int list_exit_code(std::span<const ListedDevice> devices);

/// `hapticd device list`, its arguments beginning with "device". Prints; returns the exit code.
int run_device_list(int argc, const char* const* argv);

}  // namespace hapticd
