// What is fuzzed of the gateway's server: any bytes as all that a peer sends on a connection,
// requests, handshakes, frames of a WebSocket. Not RT.
#pragma once

#include <cstdint>
#include <span>

namespace hapticd::test {

/// The token of the server that is fuzzed.
inline constexpr const char* kFuzzToken = "0123456789abcdef0123456789abcdef";

/// Sends up to 32 KiB of `bytes` to the server over loopback, and ends. The connection must end
/// too and leave no place taken; what the peer is answered must begin as HTTP with a
/// Content-Security-Policy; nothing may be done for a peer that did not send the token. Throws
/// std::logic_error where that does not hold. True when a page was welcomed.
bool check_page_connection(std::span<const std::uint8_t> bytes);

}  // namespace hapticd::test
