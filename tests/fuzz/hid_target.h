// Fuzz target: reports and descriptors of HID devices, as host and as device.
#pragma once

#include <cstdint>
#include <span>

namespace hapticd::test {

/// Reads `bytes` as each report, as a report descriptor, and as what a host sends to the reference
/// firmware while it is enabled: reports, each after a byte with its length. Throws
/// std::logic_error when a report read does not give the same one again, a descriptor tells more
/// than it may, or the firmware gives a force beyond its limits or without being enabled. Returns
/// whether it was a report or a descriptor.
bool check_hid_bytes(std::span<const std::uint8_t> bytes);

}  // namespace hapticd::test
