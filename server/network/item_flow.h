// How far virtual time may be ahead of the Items that one session has acknowledged. PROTOCOL.md,
// section 11. Pure. Not RT.
#pragma once

#include <cstddef>
#include <cstdint>

#include "proto/wire/item_outbox.h"

namespace hapticd {

/// Unacknowledged Items beyond which virtual time waits, and down to which it then does. A quarter
/// of what ends a session: one more tick brings 64 events of strings and 128 of each of 5 tools at
/// most.
inline constexpr std::size_t kMaxItemsAhead = wire::kMaxUnacknowledged / 4;
inline constexpr std::size_t kCaughtUpItems = kMaxItemsAhead / 2;
/// A session that does not run time itself is waited for while it acknowledges this many Items, a
/// Packet's worth, in such a time, ns. Longer: one that hangs holds the others up; shorter: one
/// that was merely late for once loses its session.
inline constexpr std::uint64_t kMinProgress = wire::kMaxItems;
inline constexpr std::int64_t kProgressTime_ns = 250 * wire::kMillisecond_ns;

/// Whether one session is behind.
class ItemFlow {
 public:
  /// The session has so many Items unacknowledged, and has acknowledged so many in all.
  void note(std::size_t unacknowledged, std::uint64_t acknowledged, std::int64_t now_ns) noexcept {
    const bool was_behind = behind_;
    behind_ = unacknowledged > (was_behind ? kCaughtUpItems : kMaxItemsAhead);
    const bool begins = behind_ && !was_behind;
    if (!begins && acknowledged - progress_ < kMinProgress) return;
    progress_ = acknowledged;
    progress_ns_ = now_ns;
  }
  [[nodiscard]] bool behind() const noexcept { return behind_; }
  /// Whether it still acknowledges, while behind.
  [[nodiscard]] bool progresses(std::int64_t now_ns) const noexcept {
    return now_ns - progress_ns_ <= kProgressTime_ns;
  }

 private:
  bool behind_ = false;
  std::uint64_t progress_ = 0;    ///< Items acknowledged, at
  std::int64_t progress_ns_ = 0;  ///< this instant
};

}  // namespace hapticd
