// All that waits for a reader, oldest first, in one go. The system holds this many reports and then
// drops newer ones: a queue that was full is old, and the newest report is not in it. RT as far as
// the channel's read is.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/math/realtime.h"
#include "device/api/report_channel.h"

namespace hapticd {

/// Reports that Linux's hidraw holds for a reader.
inline constexpr int kSystemQueue = 63;

enum class Drained : std::uint8_t {
  kAll,       ///< nothing waits any more
  kOverflow,  ///< the queue was full: what was given is old
  kLost,      ///< the device is gone
};

/// Gives each report that waits to `take`, as a span of bytes, its ID first.
template <typename Take>
HD_REALTIME Drained drain_queue(const ReportChannel& channel, Take take) noexcept {
  std::array<std::uint8_t, kMaxReport> bytes{};
  for (int read = 0; read <= kSystemQueue; ++read) {
    const int length = channel.read(channel.input, bytes.data(), bytes.size());
    if (length < 0) return Drained::kLost;
    if (length == 0) return read < kSystemQueue ? Drained::kAll : Drained::kOverflow;
    take(std::span<const std::uint8_t>(bytes).first(static_cast<std::size_t>(length)));
  }
  return Drained::kOverflow;
}

}  // namespace hapticd
