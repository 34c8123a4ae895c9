// See replay_device.h.
#include "device/replay/replay_device.h"

#include "device/api/command_check.h"

namespace hapticd {

bool ReplayDevice::put(const ReplayedSample& tick) noexcept {
  if (put_ - read_ == kQueue) return false;
  queue_[put_++ % kQueue] = tick;
  return true;
}

ReadOutcome ReplayDevice::read(std::int64_t /*now_ns*/, DeviceSample& sample) noexcept {
  if (read_ == put_) return ReadOutcome::kLost;
  const ReplayedSample& tick = queue_[read_++ % kQueue];
  write_good_ = tick.write_good;
  if (tick.outcome == ReadOutcome::kFresh) sample = tick.sample;
  return tick.outcome;
}

bool ReplayDevice::write(std::int64_t /*now_ns*/, const DeviceCommand& command) noexcept {
  return write_good_ && is_finite(command);
}

void ReplayDevice::write_zero(std::int64_t /*now_ns*/) noexcept {}

}  // namespace hapticd
