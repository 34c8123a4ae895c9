// See tick_pace.h.
#include "server/haptic_loop/tick_pace.h"

#include <algorithm>

#include "core/rt/monotonic_clock.h"
#include "server/haptic_loop/thread_policy.h"

namespace hapticd {

PaceClock monotonic_pace_clock() noexcept {
  return {[]() noexcept { return monotonic_now_ns(); },
          [](std::int64_t t_ns) noexcept { sleep_until(t_ns); }};
}

// Within half a frame of the time it is due lies the report nearest to it.
TickPace::TickPace(std::int64_t period_ns, const PaceSource& source,
                   const PaceClock& clock) noexcept
    : source_(source),
      clock_(clock),
      period_ns_(period_ns),
      early_ns_(std::min(period_ns / 4,
                         source.frame_ns / 2 + std::min(2 * source.frame_ns / 5, kTwoWakings_ns))),
      late_ns_(std::min(period_ns / 4, kMaxGrace_ns)),
      due_ns_(clock.now() + period_ns) {}

Waited TickPace::wait_for_report() noexcept {
  // A loop that is late has no time to wait.
  if (clock_.now() >= due_ns_) return Waited::kTime;
  clock_.sleep_until(due_ns_ - early_ns_);
  const Waited waited = source_.wait(source_.device, due_ns_ + late_ns_);
  if (waited == Waited::kGone) clock_.sleep_until(due_ns_);
  return waited;
}

DueTick TickPace::wait() noexcept {
  Waited waited = Waited::kTime;
  if (source_.wait != nullptr) {
    waited = wait_for_report();
  } else {
    clock_.sleep_until(due_ns_);
  }
  const std::int64_t now_ns = clock_.now();
  const std::int64_t late_ns = now_ns - due_ns_;
  const std::uint64_t skipped =
      late_ns >= period_ns_ ? static_cast<std::uint64_t>(late_ns / period_ns_) : 0;
  const bool by_device = waited == Waited::kReport || waited == Waited::kMissed;
  if (by_device && skipped == 0) {
    due_ns_ = now_ns + period_ns_;
  } else {
    due_ns_ += period_ns_ * static_cast<std::int64_t>(skipped + 1);
  }
  return {now_ns, skipped};
}

}  // namespace hapticd
