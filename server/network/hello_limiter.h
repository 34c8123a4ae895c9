// How many HELLOs of one IPv4 address or IPv6 /64 are looked at: a bucket of tokens each, in a
// table of fixed size under a secret hash. Pure. Not RT.
#pragma once

#include <sodium.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "proto/wire/item_outbox.h"
#include "server/network/address.h"

namespace hapticd {

/// HELLOs looked at per second, and at once after a rest. Each costs a few hashes, or a shared
/// secret once its cookie is right; a client says four a second.
inline constexpr std::int64_t kHellosPerSecond = 20;
inline constexpr std::int64_t kHelloBurst = 5;

/// Remembers who said HELLO. Those that share a place of the table share its bucket; nobody can
/// choose addresses that do so, because the hash is secret.
class HelloLimiter {
 public:
  using Secret = std::array<std::uint8_t, crypto_shorthash_KEYBYTES>;

  explicit HelloLimiter(const Secret& secret) : secret_(secret) {}

  /// Whether a HELLO from `address` is to be looked at; if so its token is taken.
  bool allow(const Address& address, std::int64_t now_ns) noexcept {
    constexpr std::int64_t kToken_ns = 1000 * wire::kMillisecond_ns / kHellosPerSecond;
    // A bucket as the instant when it was empty: full when that is a whole burst ago.
    std::int64_t& empty_ns = empty_ns_[place_of(address)];
    const std::int64_t begin_ns = std::max(empty_ns, now_ns - kHelloBurst * kToken_ns);
    if (begin_ns + kToken_ns > now_ns) return false;
    empty_ns = begin_ns + kToken_ns;
    return true;
  }

 private:
  static constexpr std::size_t kPlaces = 4096;

  [[nodiscard]] std::size_t place_of(const Address& address) const noexcept {
    const auto mapped = ipv4_address({}, 0).ip;
    const bool v4 = std::equal(mapped.begin(), mapped.begin() + 12, address.ip.begin());
    const std::span<const std::uint8_t> whole = address.ip;
    const auto network = v4 ? whole : whole.first(8);
    std::array<std::uint8_t, crypto_shorthash_BYTES> hash{};
    crypto_shorthash(hash.data(), network.data(), network.size(), secret_.data());
    return (hash[0] | static_cast<std::size_t>(hash[1]) << 8U) % kPlaces;
  }

  Secret secret_;
  std::array<std::int64_t, kPlaces> empty_ns_{};
};

}  // namespace hapticd
