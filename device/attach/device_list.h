// The devices plugged into this machine that hapticd can drive, as people and programs are told of
// them. Needs no permission for them: no device is opened. Not RT.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "device/api/driver.h"

namespace hapticd {

/// Exit codes of the list.
inline constexpr int kListGood = 0;
inline constexpr int kListForbidden = 1;  ///< this user may not open one of the devices

/// One device that a driver is for.
struct ListedDevice {
  HidrawNode node;
  const DriverEntry* driver = nullptr;  ///< never null
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

}  // namespace hapticd
