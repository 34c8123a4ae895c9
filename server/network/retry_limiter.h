// How many RETRYs one handshake gets: per address, port and ephemeral key together. Whoever sends
// the HELLO of another again spends nothing that the other needs, because each RETRY goes to the
// other and carries the cookie it waits for. A table of fixed size under a secret hash. Pure. Not
// RT.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "proto/noise/handshake.h"
#include "server/network/address.h"
#include "server/network/secret_hash.h"
#include "server/network/token_bucket.h"

namespace hapticd {

/// A place of the table belongs to who came last: a flood from many addresses makes it forget, and
/// never keeps anybody from an answer.
class RetryLimiter {
 public:
  explicit RetryLimiter(const SecretHash& hash) : hash_(hash) {}

  /// Whether a RETRY may leave for the handshake of `message`, of which the first 32 bytes are the
  /// client's public key; if so it is taken to leave.
  bool allow(const Address& to, std::span<const std::uint8_t> message, const TokenRate& rate,
             std::int64_t now_ns) noexcept {
    const std::uint64_t mark = mark_of(to, message);
    Place& place = places_[mark % places_.size()];
    if (place.mark != mark) place = {mark, {}};
    return place.bucket.take(rate, now_ns);
  }

 private:
  struct Place {
    std::uint64_t mark = 0;
    TokenBucket bucket;
  };

  [[nodiscard]] std::uint64_t mark_of(const Address& to,
                                      std::span<const std::uint8_t> message) const noexcept {
    std::array<std::uint8_t, sizeof(to.ip) + 2 + noise::kKeyBytes> bytes{};
    auto end = std::copy(to.ip.begin(), to.ip.end(), bytes.begin());
    *end++ = static_cast<std::uint8_t>(to.port);
    *end++ = static_cast<std::uint8_t>(to.port >> 8U);
    std::copy_n(message.begin(), noise::kKeyBytes, end);
    return hash_(bytes);
  }

  SecretHash hash_;
  std::array<Place, 4096> places_{};
};

}  // namespace hapticd
