// The hidraw nodes of this machine: what is plugged in, with the report descriptor of each, from
// which a driver sees whether it is one of its own. The descriptor is read from sysfs, which needs
// no permission. Linux, hidapi. Takes some ms: never in the loop's thread. Not RT.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "device/api/hidraw_node.h"

namespace hapticd {

/// Longest descriptor that Linux accepts, bytes.
inline constexpr std::size_t kMaxHidDescriptor = 4096;

/// All of them, by path, once each. `sys`: where sysfs is. Empty also where hidapi cannot look.
[[nodiscard]] std::vector<HidrawNode> list_hidraw_nodes(const std::string& sys = "/sys");

/// How it is named to people: product, serial and path.
[[nodiscard]] std::string describe(const HidrawNode& node);

}  // namespace hapticd
