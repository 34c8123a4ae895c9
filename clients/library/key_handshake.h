// The client's side of the handshake of a keyed session: HELLO, again with the cookie of a RETRY,
// until a WELCOME opens. PROTOCOL.md, section 12. Pure: no socket, no clock. Times are ns. Not RT.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "proto/noise/handshake.h"
#include "proto/noise/hello_tag.h"
#include "proto/noise/key_file.h"
#include "proto/wire/hello.h"

namespace hapticd::client {

/// A key of the server, what it is the key to, and how the server is known.
using ClientKey = noise::SessionKey;

/// The key in `file`, with its role unless `role` says another. Throws std::runtime_error with the
/// remedy when it cannot be read, is of 0.1, or users other than its owner may access it.
[[nodiscard]] ClientKey read_client_key(const std::filesystem::path& file,
                                        std::optional<wire::Role> role = std::nullopt);

/// One handshake.
class KeyHandshake {
 public:
  /// `ephemeral`: 32 random bytes, for this handshake alone.
  KeyHandshake(const ClientKey& key, const noise::Key& ephemeral);

  /// When the next HELLO has to leave; 0 = at once.
  [[nodiscard]] std::int64_t due_ns() const noexcept { return due_ns_; }
  /// The HELLO that leaves now.
  [[nodiscard]] noise::Bytes hello(std::int64_t now_ns);
  /// Takes a datagram of the server; true when it is the WELCOME: session() and transport() are
  /// the session's.
  bool receive(std::span<const std::uint8_t> datagram);

  [[nodiscard]] std::uint32_t session() const noexcept { return session_; }
  [[nodiscard]] noise::Transport transport() const { return handshake_.split(); }

 private:
  void take_cookie(std::span<const std::uint8_t> cookie);

  ClientKey key_;
  noise::KeyId key_id_;
  noise::SecretKey hello_key_;
  noise::Handshake handshake_;
  noise::Bytes message_;
  noise::Bytes cookie_;  ///< of the newest RETRY that is believed
  bool tagged_ = false;  ///< the server has signed it
  std::int64_t due_ns_ = 0;
  std::uint32_t session_ = 0;
};

}  // namespace hapticd::client
