// Fuzz target: the reader of recordings.
#pragma once

#include <cstdint>
#include <span>

namespace hapticd::test {

/// Reads `bytes` as a recording, once as they are and once with the CRCs of all chunks switched
/// off, so that what is behind them is looked at too; ticks are decoded, and the repaired file is
/// read again. Throws std::logic_error when the repaired file is not complete or gives other
/// messages. Returns whether a message was read.
bool check_recording_bytes(std::span<const std::uint8_t> bytes);

}  // namespace hapticd::test
