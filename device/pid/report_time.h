// When the reports of a device without a clock were made, from when they were read. Ticks come late
// and read several at once; reports do not crowd: each is made a report interval after the one
// before. So times go on by intervals, and are brought back into the two intervals before the
// reading when the device paused or is not as fast as it is said to be: they never drift away from
// the readings. What is read too late once is known to have been made earlier from then on. RT:
// yes.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/math/realtime.h"

namespace hapticd::pid {

/// Start again at attach.
struct ReportTime {
  std::int64_t made_ns = 0;  ///< of the newest report
  bool any = false;
};

/// When the newest of `reports` >= 1 reports was made that were read together at `read_ns`, of a
/// device that makes one in each `interval_ns` > 0. From two intervals before the reading to the
/// reading; does not decrease while `read_ns` does not.
[[nodiscard]] HD_REALTIME inline std::int64_t made_at(std::int64_t read_ns, std::int64_t reports,
                                                      std::int64_t interval_ns,
                                                      ReportTime& time) noexcept {
  const std::int64_t expected_ns =
      time.any ? time.made_ns + reports * interval_ns : read_ns - interval_ns;
  time.made_ns = std::clamp(expected_ns, read_ns - 2 * interval_ns, read_ns);
  time.any = true;
  return time.made_ns;
}

}  // namespace hapticd::pid
