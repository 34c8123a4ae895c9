// A device whose handle rings along z in a simulation and is held still along the other axes.
#pragma once

#include "core/math/realtime.h"
#include "device/api/haptic_device.h"
#include "tests/support/ringing_handle.h"

namespace hapticd::test {

class RingingDevice final : public HapticDevice {
 public:
  RingingDevice(const DeviceProfile& profile, const HandleTruth& truth, double tick_s)
      : profile_(profile), handle_(truth), tick_s_(tick_s) {
    sample_.flags = kDeviceAttached | kDeviceCalibrated;
  }
  [[nodiscard]] const DeviceProfile& profile() const noexcept override { return profile_; }
  HD_REALTIME ReadOutcome read(std::int64_t now_ns, DeviceSample& sample) noexcept override {
    ++sample_.counter;
    sample_.t_ns = now_ns;
    sample_.p_DH = {0.0, 0.0, kStart + offset + handle_.position()};
    sample = sample_;
    return ReadOutcome::kFresh;
  }
  HD_REALTIME bool write(std::int64_t /*now_ns*/, const DeviceCommand& command) noexcept override {
    written = command;
    if (free) handle_.advance(command.enable ? command.f_H_D[2] : 0.0, tick_s_);
    return true;
  }
  HD_REALTIME void write_zero(std::int64_t /*now_ns*/) noexcept override {}

  static constexpr double kStart = 0.025;
  bool free = false;    ///< until a measuring begins a hand keeps it still
  double offset = 0.0;  ///< a hand has led it away, m
  DeviceCommand written;

 private:
  DeviceProfile profile_;
  RingingHandle handle_;
  double tick_s_;
  DeviceSample sample_;
};

}  // namespace hapticd::test
