// How many handshakes cost a scalar multiplication: per address that has proved to be its own, and
// all together for keys that have been seen before. Tables of fixed size under a secret hash. Pure.
// No heap. Not RT.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "proto/wire/item_outbox.h"
#include "server/network/address.h"
#include "server/network/secret_hash.h"
#include "server/network/token_bucket.h"

namespace hapticd {

/// Handshakes of one IPv4 address or IPv6 /64 that are carried out per second, and at once after a
/// rest. A client needs one.
inline constexpr std::int64_t kHandshakesPerSecond = 20;
inline constexpr std::int64_t kHandshakeBurst = 5;
/// Those of all addresses with an ephemeral key that has had its handshake: somebody sends again
/// what he has seen, or a client has waited for longer than its handshake did.
inline constexpr std::int64_t kAgainPerSecond = 4;

/// Asked only about a HELLO whose tag and cookie are right: a forged source address costs nobody
/// anything. Addresses that share a place of the table share what is there; nobody can choose some
/// that do so, because the hash is secret. 4096 keys are remembered; to look through them costs a
/// few us, a twentieth of what it may save.
class HelloLimiter {
 public:
  explicit HelloLimiter(const SecretHash& hash) : hash_(hash) {}

  /// Whether the handshake of `ephemeral`, a client's public key, may be carried out for `address`;
  /// if so it is taken to be.
  bool allow(const Address& address, std::span<const std::uint8_t> ephemeral,
             std::int64_t now_ns) noexcept {
    constexpr std::int64_t kSecond_ns = 1000 * wire::kMillisecond_ns;
    constexpr TokenRate kOwn{kSecond_ns / kHandshakesPerSecond, kHandshakeBurst};
    constexpr TokenRate kAgain{kSecond_ns / kAgainPerSecond, kAgainPerSecond};
    const std::uint64_t mark = hash_(ephemeral);
    if (std::find(seen_.begin(), seen_.end(), mark) != seen_.end()) {
      return again_.take(kAgain, now_ns);
    }
    if (!buckets_[hash_(network_of(address)) % kPlaces].take(kOwn, now_ns)) return false;
    // The one that was seen first is forgotten for it.
    seen_[next_] = mark;
    next_ = (next_ + 1) % kPlaces;
    return true;
  }

 private:
  static constexpr std::size_t kPlaces = 4096;

  SecretHash hash_;
  std::array<TokenBucket, kPlaces> buckets_{};
  std::array<std::uint64_t, kPlaces> seen_{};  ///< a ring
  std::size_t next_ = 0;                       ///< its oldest
  TokenBucket again_;
};

}  // namespace hapticd
