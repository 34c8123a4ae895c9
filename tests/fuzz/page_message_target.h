// What is fuzzed of pages: any bytes as what three of them say to the gateway, one that only looks,
// one that may steer a recording, one that may control. Not RT.
#pragma once

#include <cstdint>
#include <span>

namespace hapticd::test {

/// Reads `bytes` as a row of messages: a byte that says from which page, whether the daemon is
/// there and what it does with what waits; their length in two bytes, the lower first; the
/// message. The hub takes each, which must be answered or be obeyed once, or close its page where
/// it is no PageRequest, and must move nothing that its page may not. Throws std::logic_error where
/// that does not hold. True when something reached the daemon, a recording or an experiment.
bool check_page_messages(std::span<const std::uint8_t> bytes);

}  // namespace hapticd::test
