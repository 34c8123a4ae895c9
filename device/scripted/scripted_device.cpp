// See scripted_device.h.
#include "device/scripted/scripted_device.h"

#include <algorithm>

#include "core/tick/sample_difference.h"
#include "device/api/command_check.h"

namespace hapticd {

ScriptedDevice::ScriptedDevice(const DeviceProfile& profile, const ScriptedOptions& options)
    : profile_(profile), ring_(kPoseQueue), hold_(options.hold) {
  last_.p_DH = options.p_DH;
  last_.q_DH = options.q_DH;
  last_.flags = kDeviceAttached | kDeviceCalibrated | kDeviceEnabled;
}

void ScriptedDevice::clear() noexcept {
  for (Slot& each : ring_) each.filled = false;
  next_tick_ = tick_;
}

void ScriptedDevice::set_tick(std::uint64_t tick) noexcept {
  if (tick < tick_) {
    tick_ = tick;
    clear();
    held_ = dropped_ = 0;
    return;
  }
  tick_ = tick;
  next_tick_ = std::max(next_tick_, tick);
}

PosePush ScriptedDevice::push(std::uint64_t tick, const QueuedPose& pose) noexcept {
  if (tick < tick_) {
    ++dropped_;
    return PosePush::kDropped;
  }
  if (tick - tick_ >= kPoseQueue) return PosePush::kFull;
  slot(tick) = {tick, true, pose};
  next_tick_ = std::max(next_tick_, tick + 1);
  return PosePush::kQueued;
}

ReadOutcome ScriptedDevice::read(std::int64_t now_ns, DeviceSample& sample) noexcept {
  Slot& due = slot(tick_);
  const bool given = due.filled && due.tick == tick_;
  due.filled = false;
  ++tick_;
  next_tick_ = std::max(next_tick_, tick_);
  if (!given) ++held_;
  if (!given && !hold_) return ReadOutcome::kNothing;
  DeviceSample next = last_;
  next.t_ns = now_ns;
  ++next.counter;
  if (given) {
    next.p_DH = due.pose.p_DH;
    next.q_DH = due.pose.q_DH;
    next.buttons = due.pose.buttons;
  }
  next.has_velocity = given && due.pose.has_velocity;
  if (next.has_velocity) {
    next.v_DH_D = due.pose.v_DH_D;
    next.w_DH_D = due.pose.w_DH_D;
  } else if (last_.counter > 0) {
    difference_velocity(last_, next);
  }
  sample = last_ = next;
  return ReadOutcome::kFresh;
}

bool ScriptedDevice::write(std::int64_t /*now_ns*/, const DeviceCommand& command) noexcept {
  return is_finite(command);
}

void ScriptedDevice::write_zero(std::int64_t /*now_ns*/) noexcept {}

}  // namespace hapticd
