// The server's side of the handshake of keyed sessions: which HELLOs are answered, with what, and
// the sessions they lead to. PROTOCOL.md, section 12. It keeps nothing of a client before a cookie
// came back, and charges nothing to an address before. Pure: no socket, no clock. Times are ns,
// never going back. Not RT.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "proto/noise/handshake.h"
#include "proto/noise/key_folder.h"
#include "proto/noise/retry_tag.h"
#include "proto/wire/hello.h"
#include "server/network/address.h"
#include "server/network/hello_limiter.h"
#include "server/network/key_ring.h"
#include "server/network/retry_limiter.h"
#include "server/network/token_bucket.h"

namespace hapticd {

/// Handshakes that wait for the first DATA; a further one is not answered, and asked for again by
/// its client.
inline constexpr std::size_t kMaxHalfOpen = 64;
/// Of them those of the view key, so that there is room for the control key's; and of those the
/// ones of one address.
inline constexpr std::size_t kMaxHalfOpenViews = 48;
inline constexpr std::size_t kMaxHalfOpenViewsOfAddress = kMaxHalfOpenViews / 4;
/// How long they wait, ns.
inline constexpr std::int64_t kHalfOpen_ns = 3000 * wire::kMillisecond_ns;
/// Age of the secret under cookies at which another takes its place, ns. Cookies of the one before
/// are good as long again.
inline constexpr std::int64_t kCookieSecret_ns = 120'000 * wire::kMillisecond_ns;
/// HELLOs without a valid cookie whose tag is looked at, per second and at once: what more come are
/// dropped unread, so that a flood leaves time for sessions. One with a cookie is always looked at.
inline constexpr std::int64_t kUnprovenPerSecond = 150'000;
inline constexpr std::int64_t kUnprovenBurst = 2000;
/// Of them those of NNpsk0, whose message 1 costs ten times as many hashes.
inline constexpr std::int64_t kUnprovenOldPerSecond = 1000;
inline constexpr std::int64_t kUnprovenOldBurst = 100;
/// Answers to one handshake, RETRYs or the same WELCOME again, per second and at once. They go to
/// its client and to nobody else, so that whoever sends its HELLO again keeps it from nothing.
inline constexpr std::int64_t kAnswersPerSecond = 20;
inline constexpr std::int64_t kAnswerBurst = 5;

/// A handshake that was answered with WELCOME.
struct HalfOpen {
  Address address;
  wire::Role role = wire::Role::kView;
  wire::Method method = wire::Method::kNKpsk0;
  noise::KeyId key_id{};  ///< of its key
  std::string key_name;   ///< of the client whose key it is; empty: view.key or control.key
  std::uint32_t session = 0;
  noise::Bytes message;  ///< the client's
  noise::Bytes welcome;  ///< the datagram, sent again for a repeated HELLO
  noise::Transport transport;
  std::int64_t since_ns = 0;
  bool established = false;  ///< its first DATA has opened: the session lives
  TokenBucket repeats;       ///< of its WELCOME
};

/// What became of HELLOs. Each is counted once.
struct HelloCounters {
  std::uint64_t retried = 0;    ///< answered with RETRY
  std::uint64_t welcomed = 0;   ///< answered with a new WELCOME
  std::uint64_t repeated = 0;   ///< answered with the WELCOME of a handshake under way
  std::uint64_t malformed = 0;  ///< dropped: of another length, role or form
  std::uint64_t forged = 0;     ///< dropped: of nobody who has the key
  std::uint64_t limited = 0;    ///< dropped: too many at once
  std::uint64_t full = 0;       ///< dropped: too many handshakes wait for their first DATA
};

/// The answers to HELLOs.
class Handshakes {
 public:
  using Random = std::function<void(std::span<std::uint8_t>)>;

  /// `random` fills bytes with random ones; empty: the system's.
  Handshakes(const noise::ServerKeys& keys, Random random);

  /// A HELLO from `from`: the datagram that answers it, RETRY or WELCOME; empty: none. Without a
  /// cookie it costs a few hashes; only with a valid one, and within its address's share, a scalar
  /// multiplication.
  [[nodiscard]] noise::Bytes receive(const Address& from, std::span<const std::uint8_t> datagram,
                                     std::int64_t now_ns);
  /// The handshake that led to this session and waits for its first DATA; null: there is none.
  /// Valid until the next call.
  [[nodiscard]] const HalfOpen* find(const Address& from, std::uint32_t session) const;
  /// Its first DATA has opened: kept until forget(), for repeated HELLOs.
  void establish(std::uint32_t session);
  /// Others take the place of its keys. Handshakes with one that is gone and has not led to a
  /// session are forgotten.
  void replace_keys(const noise::ServerKeys& keys);
  /// Whether there is a key of this id and role.
  [[nodiscard]] bool holds(const noise::KeyId& id, wire::Role role) const noexcept {
    return keys_.holds(id, role);
  }
  /// The session has ended, or never began.
  void forget(std::uint32_t session);
  /// Forgets the handshakes that have waited too long.
  void expire(std::int64_t now_ns);
  /// Handshakes that wait; `views`: those of the view key alone.
  [[nodiscard]] std::size_t half_open(bool views = false) const;
  [[nodiscard]] const HelloCounters& counters() const noexcept { return counters_; }

 private:
  static constexpr std::size_t kCookieBytes = 32;
  using Secret = std::array<std::uint8_t, 32>;
  using Cookie = std::array<std::uint8_t, kCookieBytes>;

  template <std::size_t Count>
  std::array<std::uint8_t, Count> drawn();
  void rotate(std::int64_t now_ns);
  [[nodiscard]] static Cookie cookie_of(const Secret& secret, const Address& from,
                                        std::span<const std::uint8_t> message);
  [[nodiscard]] bool is_ours(const Address& from, const wire::Hello& hello,
                             const RingKey& key) const;
  [[nodiscard]] HalfOpen* repeated(const Address& from, const wire::Hello& hello,
                                   std::int64_t now_ns);
  noise::Bytes welcome_again(HalfOpen& half, std::int64_t now_ns);
  [[nodiscard]] bool has_room(const Address& from, wire::Role role) const;
  noise::Bytes retry(const Address& from, const wire::Hello& hello, const RingKey& key,
                     std::int64_t now_ns);
  noise::Bytes welcome(const Address& from, const wire::Hello& hello, const RingKey& key,
                       std::int64_t now_ns);
  [[nodiscard]] std::uint32_t new_session();

  Random random_;
  KeyRing keys_;
  HelloLimiter limiter_;
  RetryLimiter retries_;
  TokenBucket unproven_;
  TokenBucket unproven_old_;
  HelloCounters counters_;
  Secret secret_{};
  Secret secret_before_{};
  std::optional<std::int64_t> secret_since_ns_;
  std::vector<HalfOpen> all_;
};

}  // namespace hapticd
