// How much of the network thread's time one peer may take. Pure: no clock. Times are ns, never
// going back. Not RT.
#pragma once

#include <algorithm>
#include <cstdint>

#include "proto/wire/item_outbox.h"

namespace hapticd {

/// Slice in which a peer may use up its share at once, ns.
inline constexpr std::int64_t kTimeSlice_ns = 10 * wire::kMillisecond_ns;

/// One share, kept as the instant when all that was taken is paid for. What takes longer than a
/// share of a slice is paid for in the slices after it.
class TimeBudget {
 public:
  /// Whether there is something left of this slice.
  [[nodiscard]] bool has_left(std::int64_t now_ns) const noexcept {
    return paid_ns_ - now_ns < kTimeSlice_ns;
  }
  /// Whether nothing is owed.
  [[nodiscard]] bool is_whole(std::int64_t now_ns) const noexcept { return paid_ns_ <= now_ns; }
  /// `taken_ns` were taken; `part` > 0: one part in so many is the peer's.
  void charge(std::int64_t taken_ns, std::int64_t part, std::int64_t now_ns) noexcept {
    paid_ns_ = std::max(paid_ns_, now_ns) + part * std::max<std::int64_t>(taken_ns, 0);
  }

 private:
  std::int64_t paid_ns_ = 0;
};

}  // namespace hapticd
