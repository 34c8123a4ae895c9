// The hidraw nodes of this machine: what is plugged in, with the report descriptor of each, from
// which a driver sees whether it is one of its own. The descriptor is read from sysfs, which needs
// no permission. Linux, hidapi. Takes some ms: never in the loop's thread. Not RT.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace hapticd {

/// Longest descriptor that Linux accepts, bytes.
inline constexpr std::size_t kMaxHidDescriptor = 4096;

/// A device that could be opened.
struct HidrawNode {
  std::string path;    ///< another one after every plugging
  std::string serial;  ///< printable ASCII; empty: it has none
  std::string maker;   ///< may be empty
  std::string product;
  std::uint16_t vendor_id = 0;
  std::uint16_t product_id = 0;
  std::vector<std::uint8_t> descriptor;  ///< as the device sent it: not to be trusted
  bool permitted = false;                ///< this user may read and write the node
};

/// All of them, by path, once each. `sys`: where sysfs is. Empty also where hidapi cannot look.
[[nodiscard]] std::vector<HidrawNode> list_hidraw_nodes(const std::string& sys = "/sys");

/// How it is named to people: product, serial and path.
[[nodiscard]] std::string describe(const HidrawNode& node);

}  // namespace hapticd
