// A device whose handle rings along z in a simulation and is held still along the other axes.
#pragma once

#include <memory>
#include <utility>

#include "core/math/realtime.h"
#include "device/api/haptic_device.h"
#include "tests/server/haptic_loop/loop_run.h"
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

/// The wall, played with a device that rings; nobody knows its damping nor its delay. Its settings
/// are still to be applied.
struct RingingScene {
  std::unique_ptr<PlayedScene> played = played_scene(kWallScene, 1);
  RingingDevice* handle = nullptr;

  RingingScene(const HandleTruth& truth, double tick_s) {
    PlayedTool& tool = played->tools[0];
    PlayedDevice& place = tool.device;
    auto device = std::make_unique<RingingDevice>(place.device->profile(), truth, tick_s);
    handle = device.get();
    place.facets = {};
    place.traits = {.can_push_a_person = true};
    place.device = handle;
    place.owned = std::move(device);
    tool.limits.passivity.damping = 0.0;
    tool.stiffness_limits.damping_guessed = true;
    tool.stiffness_limits.delay_unknown = true;
  }
};

}  // namespace hapticd::test
