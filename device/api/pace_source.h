// A device whose reports may say when ticks are due: the wait for its next one, apart from the
// reading of it. Plain data; wait is for the loop's thread and is the one call to a device that
// waits.
#pragma once

#include <cstdint>

namespace hapticd {

/// What ended a wait.
enum class Waited : std::uint8_t {
  kReport,  ///< one came while it lasted
  kTime,    ///< its time was over, and none has come since the last read
  kMissed,  ///< its time was over, but one had come before it began
  kGone,    ///< there is no device to wait for; it returned at once
};

/// Valid as long as the device.
struct PaceSource {
  void* device = nullptr;
  /// Waits for a report that is not there yet, until `until_ns` by the monotonic clock. What is
  /// there already is kept for the next read. No `wait`: no such device.
  Waited (*wait)(void* device, std::int64_t until_ns) noexcept = nullptr;
  std::int64_t frame_ns = 0;  ///< from report to report
};

}  // namespace hapticd
