// A device that was: the samples of a recording, one per read, decoded by the caller. Force is
// accepted and goes nowhere. At its end it is lost. RT: yes, O(1) per call.
#pragma once

#include <cstdint>
#include <span>

#include "device/api/haptic_device.h"

namespace hapticd {

class ReplayDevice final : public HapticDevice {
 public:
  /// One sample per tick, as read in that tick, all numbers kept to the bit; a counter like that of
  /// the sample before says that nothing new came in that tick. `samples` must outlive this.
  ReplayDevice(const DeviceProfile& profile, std::span<const DeviceSample> samples) noexcept
      : profile_(profile), samples_(samples) {}

  [[nodiscard]] const DeviceProfile& profile() const noexcept override { return profile_; }
  HD_REALTIME ReadOutcome read(std::int64_t now_ns, DeviceSample& sample) noexcept override;
  HD_REALTIME bool write(std::int64_t now_ns, const DeviceCommand& command) noexcept override;
  HD_REALTIME void write_zero(std::int64_t now_ns) noexcept override;

  /// Samples read so far.
  [[nodiscard]] std::size_t position() const noexcept { return position_; }
  /// The next sample to read; beyond the end: lost. Loop's thread.
  HD_REALTIME void seek(std::size_t position) noexcept { position_ = position; }

 private:
  DeviceProfile profile_;
  std::span<const DeviceSample> samples_;
  std::size_t position_ = 0;
};

}  // namespace hapticd
