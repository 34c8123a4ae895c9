// The server's side of the handshake of keyed sessions: which HELLOs are answered, with what, and
// the sessions they lead to. PROTOCOL.md, section 12. It keeps nothing of a client before a cookie
// came back. Pure: no socket, no clock. Times are ns, never going back. Not RT.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "proto/noise/handshake.h"
#include "proto/noise/key_file.h"
#include "proto/wire/hello.h"
#include "server/network/address.h"
#include "server/network/hello_limiter.h"

namespace hapticd {

/// Handshakes that wait for the first DATA; a further one is not answered, and asked for again by
/// its client.
inline constexpr std::size_t kMaxHalfOpen = 64;
/// Of them those of the view key, so that there is room for the control key's.
inline constexpr std::size_t kMaxHalfOpenViews = 56;
/// How long they wait, ns.
inline constexpr std::int64_t kHalfOpen_ns = 3000 * wire::kMillisecond_ns;
/// Age of the secret under cookies at which another takes its place, ns. Cookies of the one before
/// are good as long again.
inline constexpr std::int64_t kCookieSecret_ns = 120'000 * wire::kMillisecond_ns;

/// A handshake that was answered with WELCOME.
struct HalfOpen {
  Address address;
  wire::Role role = wire::Role::kView;
  std::uint32_t session = 0;
  noise::Bytes message;  ///< the client's
  noise::Bytes welcome;  ///< the datagram, sent again for a repeated HELLO
  noise::Transport transport;
  std::int64_t since_ns = 0;
  bool established = false;  ///< its first DATA has opened: the session lives
};

/// The answers to HELLOs.
class Handshakes {
 public:
  using Random = std::function<void(std::span<std::uint8_t>)>;

  /// `random` fills bytes with random ones; empty: the system's.
  Handshakes(const noise::KeyPair& keys, Random random);

  /// A HELLO from `from`: the datagram that answers it, RETRY or WELCOME; empty: none.
  [[nodiscard]] noise::Bytes receive(const Address& from, std::span<const std::uint8_t> datagram,
                                     std::int64_t now_ns);
  /// The handshake that led to this session and waits for its first DATA; null: there is none.
  /// Valid until the next call.
  [[nodiscard]] const HalfOpen* find(const Address& from, std::uint32_t session) const;
  /// Its first DATA has opened: kept until forget(), for repeated HELLOs.
  void establish(std::uint32_t session);
  /// The session has ended, or never began.
  void forget(std::uint32_t session);
  /// Forgets the handshakes that have waited too long.
  void expire(std::int64_t now_ns);
  /// Handshakes that wait; `views`: those of the view key alone.
  [[nodiscard]] std::size_t half_open(bool views = false) const;

 private:
  static constexpr std::size_t kCookieBytes = 32;
  using Secret = std::array<std::uint8_t, 32>;
  using Cookie = std::array<std::uint8_t, kCookieBytes>;

  template <std::size_t Count>
  std::array<std::uint8_t, Count> drawn();
  void rotate(std::int64_t now_ns);
  [[nodiscard]] static Cookie cookie_of(const Secret& secret, const Address& from,
                                        std::span<const std::uint8_t> message);
  [[nodiscard]] bool is_ours(const Address& from, const wire::Hello& hello) const;
  noise::Bytes welcome(const Address& from, const wire::Hello& hello, noise::Handshake& handshake,
                       std::int64_t now_ns);

  noise::KeyPair keys_;
  Random random_;
  HelloLimiter limiter_;
  Secret secret_{};
  Secret secret_before_{};
  std::optional<std::int64_t> secret_since_ns_;
  std::vector<HalfOpen> all_;
};

}  // namespace hapticd
