// What is fuzzed of the handshake: the messages of a stranger and of a client with a key, read by
// either side of it, and by a server with keys. Not RT.
#pragma once

#include <cstdint>
#include <span>

namespace hapticd::test {

/// `bytes`: the first says who reads the rest: bit 0: the initiator, else the responder; bit 1: it
/// is a whole datagram to a server with keys, in the middle of a handshake of a client of its own;
/// bit 2: with the cookie of this client in its place, bit 3: as the body of a DATA of its session.
/// No message but the true one may be read, no true one may be blocked by those before it; the
/// server sends nothing but HELLO's answers and DATA that its client opens, and no more bytes than
/// came before its session begins. Throws std::logic_error where that does not hold. True when the
/// server answered a datagram.
bool check_noise_bytes(std::span<const std::uint8_t> bytes);

}  // namespace hapticd::test
