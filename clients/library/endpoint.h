// A host and a port as people write them on command lines. Pure. Not RT.
#pragma once

#include <cstdint>
#include <string>

namespace hapticd::client {

/// A host (name or address) and a port.
struct Endpoint {
  std::string host = "127.0.0.1";
  std::uint16_t port = 47800;
};

/// "HOST", "HOST:PORT", "[V6]:PORT", "V6" or ":PORT"; what is left out is that of `otherwise`. Port
/// 0 only where `zero_port` says so. Throws std::invalid_argument that quotes `text` for anything
/// else.
[[nodiscard]] Endpoint parse_endpoint(const std::string& text, Endpoint otherwise = {},
                                      bool zero_port = false);

}  // namespace hapticd::client
