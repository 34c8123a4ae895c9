// Counts what comes from the daemon: bytes, and by the counters in the headers what was lost. Pure.
// Not RT.
#pragma once

#include <cstdint>

#include "proto/wire/datagram.h"

namespace hapticd::web {

/// Of a span of time that is over.
struct LinkQuality {
  double loss = 0.0;         ///< share of the datagrams sent meanwhile, [0, 1]
  double bytes_per_s = 0.0;  ///< UDP payload
};

/// Counts datagrams between two calls of roll().
class LinkMeter {
 public:
  /// A datagram came. `header` of a valid one of the session, or null.
  void take(const wire::DatagramHeader* header, std::size_t bytes) noexcept;
  /// What came since the last call. Datagrams that overtake each other across it are mistaken for
  /// lost ones and made up for in the next span, where the loss cannot fall below 0.
  LinkQuality roll(std::int64_t now_ns) noexcept;
  /// Bytes ever.
  [[nodiscard]] std::uint64_t total_bytes() const noexcept { return total_bytes_; }

 private:
  std::uint32_t session_ = 0;
  std::uint64_t next_ = 0;      ///< counter after the highest so far
  std::uint64_t expected_ = 0;  ///< next_ at the beginning of the span
  std::uint64_t received_ = 0;  ///< in the span
  std::uint64_t bytes_ = 0;     ///< in the span
  std::uint64_t total_bytes_ = 0;
  std::int64_t began_ns_ = 0;
};

}  // namespace hapticd::web
