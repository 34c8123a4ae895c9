// When ticks are due. By the timer: a period after the last one was due; a tick that comes late
// skips the periods it missed. By a device: when its report comes, so that the sample is as fresh
// as can be; then the next one is due a period later, and looked for from `early` before that until
// `late` after it. A report that comes in between begins the tick. When none does the tick goes
// without, and the next is due a period after this one was, so that a silent device is one of the
// timer; or a period after this one came, when reports come out of step: a few ticks find the step.
// A faster device is met at the report nearest to a period, never twice in one. Times by the
// monotonic clock, ns. What it does beside waiting takes 100 ns; no heap, no lock.
#pragma once

#include <cstdint>

#include "device/api/pace_source.h"

namespace hapticd {

/// How long after it was due a report is waited for, at most, ns. Longer: a lost report delays the
/// force of its tick more, and slow loops come near to what the guardian calls a stall; shorter:
/// reports that come unevenly miss their tick.
inline constexpr std::int64_t kMaxGrace_ns = 250'000;

/// How much sooner than half a frame before it is due a report is looked for, ns: two wakings take
/// so long, that of the tick the next one is counted from and that before the report. At most two
/// fifths of a frame. Longer: a faster device is met a frame too soon; shorter: one too late.
inline constexpr std::int64_t kTwoWakings_ns = 50'000;

/// The clock to wait by.
struct PaceClock {
  std::int64_t (*now)() noexcept = nullptr;
  void (*sleep_until)(std::int64_t t_ns) noexcept = nullptr;
};

/// The machine's.
[[nodiscard]] PaceClock monotonic_pace_clock() noexcept;

/// A tick that is due.
struct DueTick {
  std::int64_t now_ns = 0;
  std::uint64_t skipped = 0;  ///< periods passed over before it
};

class TickPace {
 public:
  /// The first tick is due a period from now. `source`: that of a device, or none: the timer.
  TickPace(std::int64_t period_ns, const PaceSource& source, const PaceClock& clock) noexcept;

  /// Waits until a tick is due. Loop's thread.
  [[nodiscard]] DueTick wait() noexcept;

 private:
  [[nodiscard]] Waited wait_for_report() noexcept;

  PaceSource source_;
  PaceClock clock_;
  std::int64_t period_ns_;
  std::int64_t early_ns_;  ///< of a report, before it is due
  std::int64_t late_ns_;   ///< of a report, after it was due
  std::int64_t due_ns_;
};

}  // namespace hapticd
