// Fuzz target: input reports of SpaceMice, through the whole driver.
#pragma once

#include <cstdint>
#include <span>

namespace hapticd::test {

/// Reads `bytes` as what a device sends: reports, each after a byte with its length, some ms apart.
/// Throws std::logic_error when a read is not fresh, the pose leaves the workspace, or its
/// orientation is not unit. Returns whether any report was one.
bool check_spacemouse_bytes(std::span<const std::uint8_t> bytes);

}  // namespace hapticd::test
