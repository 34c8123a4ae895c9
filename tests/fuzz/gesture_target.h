// Fuzz target: the reader of gestures, and the player for what it takes. Not RT.
#pragma once

#include <cstdint>
#include <span>

namespace hapticd::test {

/// Loads `bytes` as a gesture and, if it is taken, resolves and plays it. Throws std::logic_error
/// when a gesture is refused without a reason, or a played one leads out of what is finite. True
/// when it was taken.
bool check_gesture_bytes(std::span<const std::uint8_t> bytes);

}  // namespace hapticd::test
