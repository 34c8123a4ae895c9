// See replay_device.h.
#include "device/simulated/replay_device.h"

#include "device/simulated/command_check.h"

namespace hapticd {

ReadOutcome ReplayDevice::read(std::int64_t /*now_ns*/, DeviceSample& sample) noexcept {
  if (position_ >= samples_.size()) return ReadOutcome::kLost;
  const DeviceSample& next = samples_[position_];
  const bool same = position_ > 0 && next.counter == samples_[position_ - 1].counter;
  ++position_;
  if (same) return ReadOutcome::kNothing;
  sample = next;
  return ReadOutcome::kFresh;
}

bool ReplayDevice::write(std::int64_t /*now_ns*/, const DeviceCommand& command) noexcept {
  return is_finite(command);
}

void ReplayDevice::write_zero(std::int64_t /*now_ns*/) noexcept {}

}  // namespace hapticd
