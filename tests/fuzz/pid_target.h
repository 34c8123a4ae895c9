// Fuzz target: report descriptors of force devices of the HID PID class.
#pragma once

#include <cstdint>
#include <span>

namespace hapticd::test {

/// Reads `bytes` as a report descriptor and makes every report of the driver for what it describes.
/// Throws std::logic_error when a field lies outside its report, a bound is exceeded, or a force
/// comes out larger than asked for or of the other sign. Returns whether it was a usable device.
bool check_pid_bytes(std::span<const std::uint8_t> bytes);

}  // namespace hapticd::test
