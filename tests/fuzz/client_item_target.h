// What is fuzzed of clients: what a server may say to one that has requests under way. Not RT.
#pragma once

#include <cstdint>
#include <span>

namespace hapticd::test {

/// `bytes` is a sequence of datagrams, each after two bytes, little-endian: bits 0 to 10 its
/// length; bit 15: it is only a Packet, to which the header of the session and the next counter are
/// put; bit 14: so are the id that the client awaits and the server's boot id; bit 13: 200 ms pass
/// before it; bit 12: 11 s; bit 11: the client asks for something more. Whatever comes, the client
/// sends only valid datagrams, hears of each request once, keeps no more than came, and all that
/// hapticctl would print of it is plain text that fits the terminal. Throws std::logic_error where
/// that does not hold. True when it has heard an Item, a State or a Result.
bool check_client_items(std::span<const std::uint8_t> bytes);

}  // namespace hapticd::test
