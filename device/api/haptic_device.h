// A haptic device as the loop sees it: read a sample, write a wrench, both without waiting. Every
// driver allocates at construction and never afterwards. Time is injected, so that a device inside
// the process can run by a virtual clock. Frames and units: device_sample.h. RT: yes, but for
// construction and destruction.
#pragma once

#include <cstdint>

#include "core/math/realtime.h"
#include "core/tick/device_sample.h"
#include "device/api/device_profile.h"

namespace hapticd {

/// What read() found.
enum class ReadOutcome : std::uint8_t {
  kFresh,    ///< a sample newer than any before
  kNothing,  ///< nothing new; the sample is untouched
  kLost,     ///< the device is gone, until it is plugged in again, or has come to its end; the
             ///< sample is untouched
};

/// One device of one tool. profile, read and write are called by one thread, the loop's; write_zero
/// by any.
class HapticDevice {
 public:
  HapticDevice() = default;
  HapticDevice(const HapticDevice&) = delete;
  HapticDevice& operator=(const HapticDevice&) = delete;
  HapticDevice(HapticDevice&&) = delete;
  HapticDevice& operator=(HapticDevice&&) = delete;
  virtual ~HapticDevice() = default;

  /// What it is. Valid as long as the device; never changes.
  [[nodiscard]] virtual const DeviceProfile& profile() const noexcept = 0;

  /// Puts the newest sample into `sample`; older unread ones are dropped. Never waits. `now_ns`
  /// must not decrease from call to call.
  HD_REALTIME virtual ReadOutcome read(std::int64_t now_ns, DeviceSample& sample) noexcept = 0;

  /// Sends a command, which replaces the one before. False when it could not be sent, with the
  /// reason visible in the next read. Never waits. A command with a non-finite component is refused
  /// and zero sent instead.
  HD_REALTIME virtual bool write(std::int64_t now_ns, const DeviceCommand& command) noexcept = 0;

  /// Sends a zero wrench past the loop: from the guardian's thread when the loop hangs, or on the
  /// way down. Any thread, also while read or write run. Outlives every write with an earlier
  /// `now_ns` or the same; a later write is obeyed again.
  HD_REALTIME virtual void write_zero(std::int64_t now_ns) noexcept = 0;
};

}  // namespace hapticd
