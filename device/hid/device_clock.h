// When a report's sample was taken, by the host's clock: the device's clock and an offset, which is
// the least difference seen between arrival and sample, since a report is late but never early. Two
// clocks drift apart, so only the last half to whole second counts. RT: yes, O(1).
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "core/math/realtime.h"

namespace hapticd::hid {

/// Time over which the least difference is looked for, ns. Longer: drift of the clocks, up to 0.1
/// ms per second, shows as age; shorter: a busy second shows as freshness.
inline constexpr std::int64_t kClockWindow_ns = 500'000'000;

/// Start again at attach.
struct ClockMatch {
  /// Least arrival less sample of the present window, and of the one before.
  std::array<std::int64_t, 2> least_ns{std::numeric_limits<std::int64_t>::max(),
                                       std::numeric_limits<std::int64_t>::max()};
  std::int64_t window_end_ns = std::numeric_limits<std::int64_t>::min();  ///< device's clock
};

/// Host's time of the sample taken at `device_ns`, which was read at `arrival_ns`; never later than
/// that. Device times that do not decrease; both within 100 years of 0.
[[nodiscard]] HD_REALTIME std::int64_t host_time(std::int64_t device_ns, std::int64_t arrival_ns,
                                                 ClockMatch& match) noexcept;

}  // namespace hapticd::hid
