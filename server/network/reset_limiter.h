// At most one Reset per 100 ms and address, in a table of fixed size. Pure. Not RT.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "proto/wire/item_outbox.h"
#include "server/network/address.h"

namespace hapticd {

/// Shortest time between two Resets to one address, ns.
inline constexpr std::int64_t kResetPeriod_ns = 100 * wire::kMillisecond_ns;

/// Remembers when Resets left. Two addresses that share a place of the table share its limit: a
/// Reset is late then, and its receiver asks again.
class ResetLimiter {
 public:
  /// Whether a Reset may leave to `address` now; if so it is taken to leave.
  bool allow(const Address& address, std::int64_t now_ns) noexcept {
    std::int64_t& next_ns = next_ns_[hash_of(address) % next_ns_.size()];
    if (now_ns < next_ns) return false;
    next_ns = now_ns + kResetPeriod_ns;
    return true;
  }

 private:
  static constexpr std::size_t kPlaces = 1024;
  std::array<std::int64_t, kPlaces> next_ns_{};
};

}  // namespace hapticd
