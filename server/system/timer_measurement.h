// A bare timer loop with the policy of the haptic loop and the same short work in every tick: how
// late this machine wakes a thread, and how long it holds up one that runs. What the haptic loop
// does later or slower is its own. Not RT outside.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/rt/latency_histogram.h"

namespace hapticd {

struct TimerOptions {
  double seconds = 10.0;
  std::int64_t period_ns = 1'000'000;
  std::optional<std::uint32_t> cpu;  ///< none: any
};

struct TimerMeasurement {
  LatencyHistogram late;      ///< from the instant asked for to running
  LatencyHistogram work;      ///< processor time that the kernel books for the work of a tick
  std::uint64_t held_up = 0;  ///< ticks whose work took longer than a period
  std::uint64_t ticks = 0;    ///< that ran
  std::uint64_t skipped = 0;  ///< periods that passed before their tick could run
  std::int64_t period_ns = 1'000'000;
  bool fifo = false;    ///< SCHED_FIFO was granted
  bool locked = false;  ///< memory was locked
  std::string refused;  ///< what was not granted, for people; empty: nothing
};

/// Runs for `options.seconds`; returns then.
[[nodiscard]] TimerMeasurement measure_timer(const TimerOptions& options);

}  // namespace hapticd
