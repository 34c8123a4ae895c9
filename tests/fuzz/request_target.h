// What is fuzzed of requests: Items of a client that holds the lease, through server and desks to
// the haptic loop. Not RT.
#pragma once

#include <cstdint>
#include <span>

namespace hapticd::test {

/// `bytes`: bit 0 of the first says whether the clock is virtual. Then a row of Items, each after
/// three bytes: how many milliseconds pass before it, its length in two, the lower first. The desks
/// carry out what the server lets through; nothing may reach the loop but what it can obey, each
/// request gets one answer, whose text is short and plain, and every tick is finite with forces
/// that the devices were promised. Throws std::logic_error where that does not hold. True when a
/// request was carried out.
bool check_requests(std::span<const std::uint8_t> bytes);

}  // namespace hapticd::test
