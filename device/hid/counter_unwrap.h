// Counters of 16 and 32 bits that wrap, made into 64-bit ones that do not: seq of reports and the
// device's clock in microseconds. Right as long as less than half a turn lies between two looks:
// 32 s of reports at 1 kHz, 4 s at 8 kHz, 35 min of the clock. RT: yes, O(1).
#pragma once

#include <cstdint>
#include <limits>
#include <type_traits>

#include "core/math/realtime.h"

namespace hapticd::hid {

/// One counter of type `Raw`. Start again at attach.
template <typename Raw>
struct CounterUnwrap {
  static_assert(std::is_same_v<Raw, std::uint16_t> || std::is_same_v<Raw, std::uint32_t>);
  std::uint64_t newest = 0;  ///< 0: none yet
};

/// The 64-bit value of `raw`. The first one is raw + one turn, so that values are never 0 and an
/// older one never lies below it. Values up to half a turn behind the newest are older ones and
/// leave the newest as it is.
template <typename Raw>
[[nodiscard]] HD_REALTIME constexpr std::uint64_t unwrap(Raw raw,
                                                         CounterUnwrap<Raw>& counter) noexcept {
  constexpr std::uint64_t kTurn = std::uint64_t{std::numeric_limits<Raw>::max()} + 1;
  if (counter.newest == 0) return counter.newest = kTurn + raw;
  const auto ahead = static_cast<Raw>(raw - static_cast<Raw>(counter.newest));
  if (ahead < kTurn / 2) return counter.newest += ahead;
  return counter.newest - (kTurn - ahead);
}

}  // namespace hapticd::hid
