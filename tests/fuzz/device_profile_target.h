// What is fuzzed of device profiles: any bytes as the text of one. Not RT.
#pragma once

#include <cstdint>
#include <span>

namespace hapticd::test {

/// Reads `bytes` as a device profile. One that is taken promises what device_profile.proto says of
/// each number, finite and in its range, and is taken again as it was understood; one that is
/// refused says why, in plain text. Throws std::logic_error where that does not hold. True when it
/// was taken.
bool check_device_profile_bytes(std::span<const std::uint8_t> bytes);

}  // namespace hapticd::test
