// See hid_device.h. RT: yes, except construction, attach and detach.
#include "device/hid/hid_device.h"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <span>
#include <utility>

#include "device/hid/base_frame.h"
#include "device/hid/profile_codec.h"
#include "device/hid/profile_units.h"

namespace hapticd::hid {
namespace {

/// Places of HidCounters.
enum Count : std::uint8_t { kSamples, kSuperseded, kLostSamples, kOverflows, kTooOld, kMalformed };

constexpr std::int64_t from_us(std::uint64_t us) noexcept {
  return static_cast<std::int64_t>(us) * 1000;
}

/// Place of seq in a command; the writer puts it in, +1 for each that goes out.
constexpr std::uint8_t kSeqPlace = 2;

template <typename Command>
OutputReport output(const Command& command) noexcept {
  OutputReport report;
  const auto bytes = encode(command);
  std::copy(bytes.begin(), bytes.end(), report.bytes.begin());
  report.length = bytes.size();
  return report;
}

/// As the device reckons (PROFILE.md, Affine).
int row_bound(const std::array<std::int16_t, 6>& k_npm) noexcept {
  const auto size = [&](std::size_t entry) { return std::abs(int{k_npm[entry]}); };
  return std::max(
      {size(0) + size(3) + size(4), size(3) + size(1) + size(5), size(4) + size(5) + size(2)});
}

/// As the device reckons: K with 2 N/m more on the diagonal has no negative minor.
bool is_semidefinite(const std::array<std::int16_t, 6>& k_npm) noexcept {
  constexpr std::int64_t kRounded_npm = 2;
  const std::int64_t xx = k_npm[0] + kRounded_npm;
  const std::int64_t yy = k_npm[1] + kRounded_npm;
  const std::int64_t zz = k_npm[2] + kRounded_npm;
  const std::int64_t xy = k_npm[3];
  const std::int64_t xz = k_npm[4];
  const std::int64_t yz = k_npm[5];
  const std::int64_t of_z = xx * yy - xy * xy;
  const std::int64_t of_y = xx * zz - xz * xz;
  const std::int64_t of_x = yy * zz - yz * yz;
  const std::int64_t all = xx * of_x + 2 * xy * xz * yz - yy * xz * xz - zz * xy * xy;
  return std::min({xx, yy, zz, of_x, of_y, of_z, all}) >= 0;
}

}  // namespace

HidDevice::HidDevice(const DeviceProfile& profile, const Capabilities& capabilities,
                     ReportWriter::Clock clock, const AxisMapping& axes)
    : profile_(profile),
      capabilities_(capabilities),
      axes_(axes),
      oldest_ns_(oldest_sample_ns(capabilities.in_rate_hz)),
      writer_(clock) {}

HidDevice::~HidDevice() { detach(); }

void HidDevice::attach(const ReportChannel& channel) {
  detach();
  channel_ = channel;
  writer_.attach(channel, gate_.attachment() + 1);
  gate_.open();
}

void HidDevice::detach() {
  gate_.close();
  writer_.detach();
}

HidCounters HidDevice::counters() const noexcept {
  const auto count = [&](Count which) { return counts_[which].load(std::memory_order_relaxed); };
  return {count(kSamples),   count(kSuperseded), count(kLostSamples),
          count(kOverflows), count(kTooOld),     count(kMalformed)};
}

void HidDevice::begin_anew() noexcept {
  attachment_ = gate_.attachment();
  seq_ = {};
  clock_us_ = {};
  clock_ = {};
  echo_ = {};
  fresh_ = 0;
  has_state_ = false;
  echoed_ = false;
  enabling_ = Enabling::kOff;
}

ReadOutcome HidDevice::read(std::int64_t now_ns, DeviceSample& sample) noexcept {
  if (!gate_.enter()) return ReadOutcome::kLost;
  if (attachment_ != gate_.attachment()) begin_anew();
  const ReadOutcome outcome = writer_.failed() ? ReadOutcome::kLost : drain(now_ns, sample);
  gate_.leave(outcome == ReadOutcome::kLost);
  return outcome;
}

PaceSource HidDevice::pace() noexcept {
  PaceSource source;
  source.device = this;
  source.wait = [](void* device, std::int64_t until_ns) noexcept {
    return static_cast<HidDevice*>(device)->wait(until_ns);
  };
  source.frame_ns = frame_ns(capabilities_.in_rate_hz);
  return source;
}

// What is there already is put aside first: only the next report says when.
Waited HidDevice::wait(std::int64_t until_ns) noexcept {
  if (!gate_.enter()) return Waited::kGone;
  if (attachment_ != gate_.attachment()) begin_anew();
  const bool lost = gather() == Drained::kLost || channel_.wait == nullptr;
  const bool one_before = fresh_ > 0;
  const int came = lost ? -1 : channel_.wait(channel_.input, until_ns);
  gate_.leave(false);
  if (came < 0) return Waited::kGone;
  if (came > 0) return Waited::kReport;
  return one_before ? Waited::kMissed : Waited::kTime;
}

Drained HidDevice::gather() noexcept {
  const Drained drained = drain_queue(channel_, [&](std::span<const std::uint8_t> bytes) {
    StateReport state;
    if (decode_state(bytes, state) != Decoded::kOk) {
      counts_[kMalformed].fetch_add(1, std::memory_order_relaxed);
      return;
    }
    newest_ = state;
    ++fresh_;
  });
  if (drained == Drained::kOverflow) {
    counts_[kOverflows].fetch_add(1, std::memory_order_relaxed);
    fresh_ = 0;
  }
  return drained;
}

ReadOutcome HidDevice::drain(std::int64_t now_ns, DeviceSample& sample) noexcept {
  if (gather() == Drained::kLost) return ReadOutcome::kLost;
  const std::uint64_t fresh = std::exchange(fresh_, 0);
  if (fresh == 0) return ReadOutcome::kNothing;
  counts_[kSuperseded].fetch_add(fresh - 1, std::memory_order_relaxed);
  return take(newest_, fresh - 1, now_ns, sample);
}

ReadOutcome HidDevice::take(const StateReport& state, std::uint64_t superseded, std::int64_t now_ns,
                            DeviceSample& sample) noexcept {
  const std::uint64_t before = seq_.newest;
  const std::uint64_t seq = unwrap(state.seq, seq_);
  if (has_state_ && seq <= before) return ReadOutcome::kNothing;
  if (!has_state_) seq_base_ = seq - (counter_ + 1);
  const std::int64_t device_ns = from_us(unwrap(state.t_us, clock_us_));
  state_ = state;
  has_state_ = true;
  const std::uint64_t missing = seq - seq_base_ - counter_ - 1;
  counts_[kLostSamples].fetch_add(missing - std::min(missing, superseded),
                                  std::memory_order_relaxed);
  counter_ = seq - seq_base_;
  t_ns_ = std::max(t_ns_ + 1, host_time(device_ns, now_ns, clock_));
  note_sample(counter_, device_ns, echo_);
  note_echo_of(state, device_ns);
  if (now_ns - t_ns_ > oldest_ns_) {
    counts_[kTooOld].fetch_add(1, std::memory_order_relaxed);
    return ReadOutcome::kNothing;
  }
  counts_[kSamples].fetch_add(1, std::memory_order_relaxed);
  to_sample(state, capabilities_, sample);
  into_base(axes_, sample);
  add_flags(sample);
  sample.t_ns = t_ns_;
  sample.counter = counter_;
  if (echo_.estimator.estimate_ns >= 0) {
    sample.measured_delay_s = 1e-9 * static_cast<double>(echo_.estimator.estimate_ns);
  }
  return ReadOutcome::kFresh;
}

// What takes ENABLE back without a word of why is a fault.
void HidDevice::add_flags(DeviceSample& sample) const noexcept {
  constexpr unsigned kReasons = kDeviceEmergencyStop | kDeviceWatchdogFired;
  unsigned flags = sample.flags;
  const bool dead_man = (capabilities_.caps & kHasDeadMan) != 0;
  if (dead_man && (flags & kDeviceDeadManHeld) == 0) flags |= kDeviceDeadManOpen;
  const bool explained = (flags & (kReasons | kDeviceDeadManOpen)) != 0;
  if (enabling_ == Enabling::kDropped && !explained) flags |= kDeviceReportsFault;
  sample.flags = static_cast<std::uint16_t>(flags);
}

void HidDevice::note_echo_of(const StateReport& state, std::int64_t device_ns) noexcept {
  if (state.cmd_age == kOldestCommand) return;
  const std::optional<std::uint64_t> counter = writer_.sent(state.cmd_seq);
  if (!counter) return;
  echoed_ = true;
  note_echo(*counter, device_ns - from_us(10) * state.cmd_age, echo_);
}

void HidDevice::advance_enabling(bool wanted) noexcept {
  const bool enabled = has_state_ && (state_.status & kStatusEnabled) != 0;
  const bool ready = has_state_ && (state_.status & kStatusCalibrated) != 0 && echoed_;
  if (!wanted) {
    enabling_ = Enabling::kOff;
  } else if (enabling_ == Enabling::kOff && ready && !enabled) {
    enabling_ = Enabling::kAsking;
  } else if (enabling_ == Enabling::kAsking && enabled) {
    enabling_ = Enabling::kOn;
  } else if (enabling_ == Enabling::kOn && !enabled) {
    enabling_ = Enabling::kDropped;
  }
}

// The spring is about the pose of a State, which must be the one the command was made from.
bool HidDevice::told_as_spring(const DeviceCommand& command, const CommandReport& base,
                               AffineReport& report) const noexcept {
  const bool offered = profile_.affine && (capabilities_.caps & kCanAffine) != 0;
  if (!offered || enabling_ != Enabling::kOn || is_none(command.spring)) return false;
  if (command.sample_counter != counter_) return false;
  const AffineGains gains{command.spring.K_D, {}, command.spring.Kr_D, {}};
  if (!to_affine(command, gains, report)) return false;
  report.base = base;
  return row_bound(report.k_npm) <= capabilities_.k_max_npm && is_semidefinite(report.k_npm);
}

bool HidDevice::write(std::int64_t now_ns, const DeviceCommand& command) noexcept {
  CommandReport report;
  DeviceCommand told = command;
  from_base(axes_, told);
  const bool finite = to_command(told, report);
  advance_enabling(command.enable && finite && !command.clear_faults);
  if (enabling_ != Enabling::kOn) report = CommandReport{};
  if (enabling_ == Enabling::kAsking || enabling_ == Enabling::kOn) report.flags = kCommandEnable;
  if (command.clear_faults) report.flags = kCommandClearFault;
  report.ref_seq = state_.seq;
  const bool stuck = writer_.stuck(now_ns);
  PostedCommand posted;
  AffineReport with_spring;
  const bool affine = finite && told_as_spring(told, report, with_spring);
  posted.reports.push_back(affine ? output(with_spring) : output(report));
  posted.instead.push_back(output(CommandReport{}));
  posted.posted_ns = now_ns;
  posted.attachment = attachment_;
  posted.number_at = kSeqPlace;
  posted.tag = command.sample_counter;
  // What takes force away is never out of date.
  if ((report.flags & kCommandEnable) != 0) posted.expires_ns = command.expires_ns;
  writer_.post(posted);
  return finite && !stuck && !writer_.failed();
}

void HidDevice::write_zero(std::int64_t now_ns) noexcept { writer_.revoke(now_ns); }

}  // namespace hapticd::hid
