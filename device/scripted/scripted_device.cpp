// See scripted_device.h.
#include "device/scripted/scripted_device.h"

#include <algorithm>
#include <cmath>

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
    held_ = dropped_ = last_tick_ = 0;
    return;
  }
  tick_ = tick;
  next_tick_ = std::max(next_tick_, tick);
}

PosePush ScriptedDevice::push(std::uint64_t tick, const QueuedPose& pose) noexcept {
  if (tick < tick_) {
    // On the real clock a pose that is late, but newer than the last, is the best there is.
    const bool is_best = !hold_ && tick > last_tick_ && !slot(tick_).filled;
    if (!is_best) {
      ++dropped_;
      return PosePush::kDropped;
    }
    slot(tick_) = {tick_, true, pose, 0};
    last_tick_ = tick;
    next_tick_ = std::max(next_tick_, tick_ + 1);
    return PosePush::kQueued;
  }
  if (tick - tick_ >= kPoseQueue) return PosePush::kFull;
  slot(tick) = {tick, true, pose, now_ns_};
  next_tick_ = std::max(next_tick_, tick + 1);
  return PosePush::kQueued;
}

ReadOutcome ScriptedDevice::read(std::int64_t now_ns, DeviceSample& sample) noexcept {
  Slot& due = slot(tick_);
  const bool given = due.filled && due.tick == tick_;
  due.filled = false;
  if (given) learn_wait(due, now_ns);
  if (given) last_tick_ = std::max(last_tick_, tick_);
  now_ns_ = now_ns;
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
  last_ = next;
  sample = last_;
  return ReadOutcome::kFresh;
}

// Whoever sends further ahead waits longer for the force. What is learned never falls: stiffness
// must not grow by itself under a hand.
void ScriptedDevice::learn_wait(const Slot& slot, std::int64_t now_ns) noexcept {
  if (hold_ || !profile_.force_reaches_hand || slot.given_ns == 0) return;
  if (!add_delay(now_ns - slot.given_ns, wait_)) return;
  const double wait_s = 1e-9 * static_cast<double>(wait_.estimate_ns);
  if (!(wait_s > profile_.delay + kUsualWait_s)) return;
  const double known_s =
      std::isnan(last_.measured_delay_s) ? profile_.delay : last_.measured_delay_s;
  last_.measured_delay_s = std::clamp(wait_s, known_s, std::max(known_s, kMostLearned_s));
}

bool ScriptedDevice::write(std::int64_t /*now_ns*/, const DeviceCommand& command) noexcept {
  return is_finite(command);
}

void ScriptedDevice::write_zero(std::int64_t /*now_ns*/) noexcept {}

}  // namespace hapticd
