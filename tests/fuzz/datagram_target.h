// What is fuzzed of the network: datagrams to a server with sessions open. Not RT.
#pragma once

#include <cstdint>
#include <span>

namespace hapticd::test {

/// `bytes` is a sequence of datagrams, each after two bytes, little-endian: bits 0 to 10 its
/// length; bit 15: it is only a Packet, to which the header of the open session and the next
/// counter are put; bit 14: 3 s pass before it; bit 13: it comes from another address. What is
/// missing at the end counts as cut off. Whatever comes, the server must send only valid datagrams
/// of at most 1200 bytes, keep at most 32 sessions, and have none left 12 s after the last one;
/// throws std::logic_error where that does not hold. True when some datagram was taken.
bool check_datagram_bytes(std::span<const std::uint8_t> bytes);

}  // namespace hapticd::test
