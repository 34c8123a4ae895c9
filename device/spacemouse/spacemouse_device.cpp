// See spacemouse_device.h. RT: yes, except construction, attach and detach.
#include "device/spacemouse/spacemouse_device.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/math/rotation.h"
#include "core/tick/sample_difference.h"
#include "device/report_io/drained_queue.h"

namespace hapticd::spacemouse {
namespace {

/// Places of SpacemouseCounters.
enum Count : std::uint8_t { kReports, kMalformed, kOverflows };

Array3 without_dead_zone(const Array3& raw, double dead_zone) noexcept {
  Array3 moved = raw;
  for (double& value : moved) {
    if (std::abs(value) <= dead_zone) value = 0.0;
  }
  return moved;
}

/// How long of the time from `from_ns` to `to_ns` a rate held, s.
double held_for(std::int64_t from_ns, std::int64_t to_ns, std::int64_t until_ns) noexcept {
  const std::int64_t end_ns = std::min(to_ns, until_ns);
  return end_ns > from_ns ? 1e-9 * static_cast<double>(end_ns - from_ns) : 0.0;
}

}  // namespace

SpacemouseDevice::SpacemouseDevice(const DeviceProfile& profile, const SpacemouseSettings& settings)
    : profile_(profile), settings_(settings) {
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    X_DH_.p[i] = std::clamp(0.0, profile.workspace_lower[axis], profile.workspace_upper[axis]);
  }
}

void SpacemouseDevice::attach(const ReportChannel& channel) {
  detach();
  channel_ = channel;
  gate_.open();
}

SpacemouseCounters SpacemouseDevice::counters() const noexcept {
  const auto count = [&](Count which) { return counts_[which].load(std::memory_order_relaxed); };
  return {count(kReports), count(kMalformed), count(kOverflows)};
}

void SpacemouseDevice::begin_anew(std::int64_t now_ns) noexcept {
  attachment_ = gate_.attachment();
  v_ = w_ = {};
  buttons_ = 0;
  last_ns_ = now_ns;
}

ReadOutcome SpacemouseDevice::read(std::int64_t now_ns, DeviceSample& sample) noexcept {
  if (!gate_.enter()) return ReadOutcome::kLost;
  if (attachment_ != gate_.attachment()) begin_anew(now_ns);
  // What was held until now first: a report gives the deflection from here on.
  advance(now_ns);
  const bool alive = drain(now_ns);
  gate_.leave(!alive);
  if (!alive) return ReadOutcome::kLost;
  DeviceSample fresh;
  fresh.t_ns = now_ns;
  fresh.counter = ++counter_;
  fresh.p_DH = to_array(X_DH_.p);
  fresh.q_DH = to_array(X_DH_.q);
  if (counter_ > 1) difference_velocity(last_, fresh);
  fresh.buttons = buttons_;
  fresh.flags = kDeviceAttached | kDeviceCalibrated;
  sample = last_ = fresh;
  return ReadOutcome::kFresh;
}

void SpacemouseDevice::advance(std::int64_t now_ns) noexcept {
  const Vector3 moved = to_vector(v_.value) * held_for(last_ns_, now_ns, v_.until_ns);
  const Vector3 turned = to_vector(w_.value) * held_for(last_ns_, now_ns, w_.until_ns);
  last_ns_ = std::max(last_ns_, now_ns);
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    X_DH_.p[i] = std::clamp(X_DH_.p[i] + moved[i], profile_.workspace_lower[axis],
                            profile_.workspace_upper[axis]);
  }
  X_DH_.q = renormalised(exp_rotation(turned) * X_DH_.q);
}

bool SpacemouseDevice::drain(std::int64_t now_ns) noexcept {
  const Drained drained = drain_queue(
      channel_, [&](std::span<const std::uint8_t> bytes) { take(decode(bytes), now_ns); });
  if (drained == Drained::kOverflow) {
    // The newest were dropped: where the cap is now is unknown.
    counts_[kOverflows].fetch_add(1, std::memory_order_relaxed);
    v_ = w_ = {};
  }
  return drained != Drained::kLost;
}

void SpacemouseDevice::take(const Report& report, std::int64_t now_ns) noexcept {
  const bool malformed = report.content == Content::kMalformed;
  counts_[malformed ? kMalformed : kReports].fetch_add(1, std::memory_order_relaxed);
  const AxisMapping& axes = settings_.axes;
  if (report.content == Content::kTranslation || report.content == Content::kMotion) {
    v_.value = position_in_base(axes, without_dead_zone(report.translation, axes.dead_zone));
    v_.until_ns = now_ns + kSilence_ns;
  }
  if (report.content == Content::kRotation || report.content == Content::kMotion) {
    w_.value = rotation_in_base(axes, without_dead_zone(report.rotation, axes.dead_zone));
    w_.until_ns = now_ns + kSilence_ns;
  }
  if (report.content != Content::kButtons) return;
  buttons_ = 0;
  for (std::size_t i = 0; i < settings_.button.size(); ++i) {
    const std::uint8_t of_device = settings_.button[i];
    if (of_device < 32 && (report.buttons >> of_device & 1U) != 0) {
      buttons_ |= 1U << i;
    }
  }
}

bool SpacemouseDevice::write(std::int64_t /*now_ns*/, const DeviceCommand& command) noexcept {
  for (const Array3& vector : {command.f_H_D, command.t_H_D}) {
    for (const double value : vector) {
      if (!std::isfinite(value)) return false;
    }
  }
  return true;
}

void SpacemouseDevice::write_zero(std::int64_t /*now_ns*/) noexcept {}

}  // namespace hapticd::spacemouse
