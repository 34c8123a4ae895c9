// See pid_device.h. RT: yes, except construction, attach and detach.
#include "device/pid/pid_device.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/tick/sample_difference.h"
#include "device/report_io/drained_queue.h"

namespace hapticd::pid {
namespace {

/// Places of PidCounters.
enum Count : std::uint8_t { kSamples, kSuperseded, kOverflows, kCut, kStates };

bool is_finite(const DeviceCommand& command) noexcept {
  for (const Array3& vector : {command.f_H_D, command.t_H_D}) {
    for (const double value : vector) {
      if (!std::isfinite(value)) return false;
    }
  }
  return true;
}

EffectBlocks unpack(std::uint16_t blocks) noexcept {
  return {static_cast<std::uint8_t>(blocks & 0xFFU), static_cast<std::uint8_t>(blocks >> 8U)};
}

/// From the middle of the logical range, raw units.
double centred(const BitField& axis, std::span<const std::uint8_t> report) noexcept {
  const double middle =
      0.5 * (static_cast<double>(axis.minimum) + static_cast<double>(axis.maximum));
  return static_cast<double>(get(axis, report)) - middle;
}

}  // namespace

PidDevice::PidDevice(const DeviceProfile& profile, const PidSettings& settings,
                     ReportWriter::Clock clock)
    : profile_(profile),
      settings_(settings),
      interval_ns_(report_interval_ns(profile)),
      writer_(clock) {}

void PidDevice::attach(const ReportChannel& channel, const EffectBlocks& blocks) {
  detach();
  channel_ = channel;
  blocks_.store(static_cast<std::uint16_t>(blocks[0] | unsigned{blocks[1]} << 8U),
                std::memory_order_relaxed);
  writer_.attach(channel, gate_.attachment() + 1);
  attached_ = true;
  gate_.open();
}

void PidDevice::detach() {
  gate_.close();
  writer_.detach();
  if (attached_) stop(settings_.layout, unpack(blocks_.load()), channel_);
  attached_ = false;
}

PidCounters PidDevice::counters() const noexcept {
  const auto count = [&](Count which) { return counts_[which].load(std::memory_order_relaxed); };
  return {count(kSamples), count(kSuperseded), count(kOverflows), count(kCut), count(kStates)};
}

ReadOutcome PidDevice::read(std::int64_t now_ns, DeviceSample& sample) noexcept {
  if (!gate_.enter()) return ReadOutcome::kLost;
  if (attachment_ != gate_.attachment()) {
    attachment_ = gate_.attachment();
    has_sample_ = false;
    report_time_ = {};
    enabled_ = saturated_ = let_go_ = false;
  }
  const ReadOutcome outcome = writer_.failed() ? ReadOutcome::kLost : drain(now_ns, sample);
  gate_.leave(outcome == ReadOutcome::kLost);
  return outcome;
}

ReadOutcome PidDevice::drain(std::int64_t now_ns, DeviceSample& sample) noexcept {
  const PidLayout& layout = settings_.layout;
  const ReportForm& form = layout.input.report;
  const ReportForm& state = layout.state.report;
  const bool was_off = let_go_;
  std::uint64_t fresh = 0;
  const Drained drained = drain_queue(channel_, [&](std::span<const std::uint8_t> bytes) {
    if (state.bytes != 0 && bytes[0] == state.id && bytes.size() >= state.bytes) obey_state(bytes);
    if (bytes[0] != form.id || bytes.size() < form.bytes) return;
    std::copy(bytes.begin(), bytes.end(), newest_.begin());
    ++fresh;
  });
  if (drained == Drained::kLost) return ReadOutcome::kLost;
  if (drained == Drained::kOverflow) {
    counts_[kOverflows].fetch_add(1, std::memory_order_relaxed);
    return ReadOutcome::kNothing;
  }
  // A stick that lies still may say nothing but that it lets go.
  if (fresh == 0 && has_sample_ && was_off != let_go_) fresh = 1;
  if (fresh == 0) return ReadOutcome::kNothing;
  counts_[kSuperseded].fetch_add(fresh - 1, std::memory_order_relaxed);
  counts_[kSamples].fetch_add(1, std::memory_order_relaxed);
  // Another channel's last report may lie within what the first one of this is given.
  const std::int64_t made_ns =
      made_at(now_ns, static_cast<std::int64_t>(fresh), interval_ns_, report_time_);
  sample.t_ns = std::max(last_.t_ns, made_ns);
  sample.counter = last_.counter + fresh;
  take(std::span<const std::uint8_t>(newest_).first(form.bytes), sample);
  return ReadOutcome::kFresh;
}

// What the device does not tell of counts as well.
void PidDevice::obey_state(std::span<const std::uint8_t> report) noexcept {
  const PidLayout::State& state = settings_.layout.state;
  const auto is_off = [&](const BitField& field) {
    return field.exists() && get(field, report) == 0;
  };
  counts_[kStates].fetch_add(1, std::memory_order_relaxed);
  let_go_ = get(state.paused, report) != 0 || is_off(state.actuators) || is_off(state.power);
  if (settings_.has_switches) {
    let_go_ = let_go_ || is_off(state.safety_switch) || is_off(state.force_switch);
  }
}

/// Fills in all but time and counter, which `sample` has.
void PidDevice::take(std::span<const std::uint8_t> report, DeviceSample& sample) noexcept {
  const PidLayout::Input& input = settings_.layout.input;
  DeviceSample fresh;
  fresh.t_ns = sample.t_ns;
  fresh.counter = sample.counter;
  fresh.p_DH =
      position_in_base(settings_.axes, {centred(input.x, report), centred(input.y, report), 0.0});
  if (has_sample_) difference_velocity(last_, fresh);
  for (std::size_t i = 0; i < input.button.size(); ++i) {
    if (get(input.button[i], report) == 0) continue;
    fresh.buttons |= 1U << i;
  }
  fresh.flags = kDeviceAttached | kDeviceCalibrated;
  if (enabled_) fresh.flags = static_cast<std::uint16_t>(fresh.flags | kDeviceEnabled);
  if (saturated_) fresh.flags = static_cast<std::uint16_t>(fresh.flags | kDeviceSaturated);
  if (let_go_) {
    const unsigned motors_off = fresh.flags & ~static_cast<unsigned>(kDeviceEnabled);
    fresh.flags = static_cast<std::uint16_t>(motors_off | kDeviceDeadManOpen);
  }
  has_sample_ = true;
  sample = last_ = fresh;
}

/// The command in raw units, what the device has no motor for left away, and cut to the peak.
Array3 PidDevice::magnitudes(const DeviceCommand& command) noexcept {
  constexpr std::uint8_t kRawZ = 2;
  Array3 f_D{};
  double largest = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (settings_.axes.raw_axis[i] != kRawZ) f_D[i] = command.f_H_D[i];
    largest = std::max(largest, std::abs(f_D[i]));
  }
  if (largest == 0.0) return {};
  // Relative to the largest component, so that no square overflows.
  double square = 0.0;
  for (const double f : f_D) square += f / largest * (f / largest);
  const double relative = std::sqrt(square);
  saturated_ = largest * relative > profile_.peak_force;
  if (saturated_) {
    counts_[kCut].fetch_add(1, std::memory_order_relaxed);
    for (double& f : f_D) f = f / largest * (profile_.peak_force / relative);
  }
  return raw_force(settings_.axes, f_D);
}

bool PidDevice::write(std::int64_t now_ns, const DeviceCommand& command) noexcept {
  const bool finite = is_finite(command);
  enabled_ = command.enable && finite && !let_go_;
  saturated_ = false;
  const Array3 magnitude = enabled_ ? magnitudes(command) : Array3{};
  const EffectBlocks blocks = unpack(blocks_.load(std::memory_order_relaxed));
  PostedCommand posted;
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    posted.reports.push_back(set_force(settings_.layout, blocks[axis], magnitude[axis]));
    posted.instead.push_back(set_force(settings_.layout, blocks[axis], 0.0));
  }
  posted.posted_ns = now_ns;
  posted.attachment = attachment_;
  posted.expires_ns = command.expires_ns;
  const bool stuck = writer_.stuck(now_ns);
  writer_.post(posted);
  return finite && !stuck && !writer_.failed();
}

void PidDevice::write_zero(std::int64_t now_ns) noexcept { writer_.revoke(now_ns); }

}  // namespace hapticd::pid
