// See faulty_device.h.
#include "device/faulty/faulty_device.h"

#include <time.h>  // nanosleep is POSIX

#include <charconv>
#include <limits>
#include <utility>

namespace hapticd {

std::optional<Injection> parse_injection(std::string_view text) {
  const std::size_t colon = text.find(':');
  Injection injection;
  if (colon != std::string_view::npos) {
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data() + colon + 1, end, injection.seed);
    if (error != std::errc() || stop != end) return std::nullopt;
  }
  for (const InjectedKind& kind : kInjectedKinds) {
    if (kind.name != text.substr(0, colon)) continue;
    injection.fault = kind.fault;
    return injection;
  }
  return std::nullopt;
}

FaultyDevice::FaultyDevice(std::unique_ptr<HapticDevice> device, const Injection& injection)
    : device_(std::move(device)),
      injection_(injection),
      random_(injection.seed),
      way_(kInjectedDelay) {}

// SplitMix64 (Steele, Lea, Flood 2014): equal for equal seeds everywhere.
std::int64_t FaultyDevice::draw(std::int64_t from, std::int64_t to) noexcept {
  random_ += 0x9e3779b97f4a7c15U;
  std::uint64_t z = random_;
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
  z ^= z >> 31U;
  return from + static_cast<std::int64_t>(z % static_cast<std::uint64_t>(to - from));
}

void FaultyDevice::follow_schedule(std::int64_t now_ns) noexcept {
  if (!begun_) {
    begun_ = true;
    change_ns_ = now_ns + draw(kQuietFrom_ns, kQuietTo_ns);
  }
  if (now_ns < change_ns_) return;
  spoiling_ = !spoiling_;
  const std::int64_t length_ns =
      spoiling_ ? draw(kFaultFrom_ns, kFaultTo_ns) : draw(kQuietFrom_ns, kQuietTo_ns);
  change_ns_ = now_ns + length_ns;
}

void FaultyDevice::hold_up(bool begins) const noexcept {
  std::int64_t ns = 0;
  if (injection_.fault == InjectedFault::kStall && begins) ns = kInjectedStall_ns;
  if (injection_.fault == InjectedFault::kLate) ns = 5 * injection_.period_ns / 2;
  if (ns == 0) return;
  const timespec time{static_cast<time_t>(ns / 1'000'000'000),
                      static_cast<long>(ns % 1'000'000'000)};
  nanosleep(&time, nullptr);
}

ReadOutcome FaultyDevice::spoil(ReadOutcome outcome, const DeviceSample& fresh, bool begins,
                                DeviceSample& sample) noexcept {
  if (injection_.fault == InjectedFault::kDetach) return ReadOutcome::kLost;
  if (injection_.fault == InjectedFault::kLost) return ReadOutcome::kNothing;
  if (injection_.fault == InjectedFault::kDelay) {
    if (begins) way_next_ = way_count_ = 0;
    if (outcome != ReadOutcome::kFresh) return outcome;
    const bool full = way_count_ == way_.size();
    if (full) sample = way_[way_next_];
    if (!full) ++way_count_;
    way_[way_next_] = fresh;
    way_next_ = (way_next_ + 1) % way_.size();
    return full ? ReadOutcome::kFresh : ReadOutcome::kNothing;
  }
  if (outcome != ReadOutcome::kFresh) return outcome;
  sample = fresh;
  switch (injection_.fault) {
    case InjectedFault::kNan:
      sample.p_DH[1] = std::numeric_limits<double>::quiet_NaN();
      break;
    case InjectedFault::kInf:
      sample.p_DH[2] = -std::numeric_limits<double>::infinity();
      break;
    case InjectedFault::kQuaternion:
      sample.q_DH = {};
      break;
    case InjectedFault::kFlip:
      flipped_ = !flipped_;
      if (!flipped_) break;
      for (double& component : sample.q_DH) component = -component;
      break;
    case InjectedFault::kFrozen:
      sample.p_DH = last_.p_DH;
      sample.q_DH = last_.q_DH;
      sample.v_DH_D = {};
      sample.w_DH_D = {};
      break;
    case InjectedFault::kJump:
      sample.p_DH[0] += kInjectedJump;
      break;
    default:
      break;
  }
  return outcome;
}

ReadOutcome FaultyDevice::read(std::int64_t now_ns, DeviceSample& sample) noexcept {
  const bool before = spoiling_;
  follow_schedule(now_ns);
  DeviceSample fresh;
  const ReadOutcome outcome = device_->read(now_ns, fresh);
  if (!spoiling_) {
    if (outcome == ReadOutcome::kFresh) sample = last_ = fresh;
    return outcome;
  }
  hold_up(!before);
  return spoil(outcome, fresh, !before, sample);
}

bool FaultyDevice::write(std::int64_t now_ns, const DeviceCommand& command) noexcept {
  if (spoiling_ && injection_.fault == InjectedFault::kWrite) return false;
  return device_->write(now_ns, command);
}

void FaultyDevice::write_zero(std::int64_t now_ns) noexcept { device_->write_zero(now_ns); }

}  // namespace hapticd
