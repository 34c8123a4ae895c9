// A device that was: what each read of a recording found and what became of each command, queued
// tick by tick by the reader of the recording. Force is accepted and goes nowhere. With nothing
// queued it is lost. RT: yes, O(1) per call.
#pragma once

#include <array>
#include <cstdint>

#include "device/api/haptic_device.h"
#include "device/api/sample_source.h"

namespace hapticd {

class ReplayDevice final : public HapticDevice, public SampleSource {
 public:
  /// Ticks that may be queued.
  static constexpr std::size_t kQueue = 64;

  /// `profile` is that of the device recorded, its driver included: the loop treats it as that one.
  explicit ReplayDevice(const DeviceProfile& profile) noexcept : profile_(profile) {}

  [[nodiscard]] const DeviceProfile& profile() const noexcept override { return profile_; }
  HD_REALTIME ReadOutcome read(std::int64_t now_ns, DeviceSample& sample) noexcept override;
  HD_REALTIME bool write(std::int64_t now_ns, const DeviceCommand& command) noexcept override;
  HD_REALTIME void write_zero(std::int64_t now_ns) noexcept override;

  HD_REALTIME bool put(const ReplayedSample& tick) noexcept override;

 private:
  DeviceProfile profile_;
  std::array<ReplayedSample, kQueue> queue_;
  std::uint64_t put_ = 0;
  std::uint64_t read_ = 0;
  bool write_good_ = true;
};

}  // namespace hapticd
