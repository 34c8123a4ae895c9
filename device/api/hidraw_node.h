// A HID device that is plugged in, as the system tells of it. Plain data.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace hapticd {

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

}  // namespace hapticd
