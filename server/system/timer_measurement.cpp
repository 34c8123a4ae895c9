// See timer_measurement.h.
#include "server/system/timer_measurement.h"

#include <sys/mman.h>

#include <atomic>
#include <cerrno>
#include <memory>
#include <system_error>
#include <thread>

#include "core/rt/monotonic_clock.h"
#include "server/haptic_loop/thread_policy.h"

namespace hapticd {
namespace {

/// Steps of the work of a tick: some ten microseconds, as a tick of a small scene.
constexpr int kWorkSteps = 20'000;

/// The same work every time: a chain of operations that nothing can shorten.
std::uint64_t work(std::uint64_t x) noexcept {
  for (int k = 0; k < kWorkSteps; ++k) {
    x = x * 6364136223846793005U + 1442695040888963407U;
    asm volatile("" : "+r"(x));
  }
  return x;
}

void run(const TimerOptions& options, const std::atomic<bool>& go, TimerMeasurement& out) {
  prefault_stack();
  while (!go.load(std::memory_order_acquire)) sleep_until(monotonic_now_ns() + options.period_ns);
  const std::int64_t begin_ns = monotonic_now_ns();
  const std::int64_t end_ns = begin_ns + static_cast<std::int64_t>(options.seconds * 1e9);
  std::int64_t due_ns = begin_ns + options.period_ns;
  std::uint64_t state = 1;
  while (due_ns <= end_ns) {
    sleep_until(due_ns);
    const std::int64_t late_ns = monotonic_now_ns() - due_ns;
    record(out.late, late_ns);
    const std::int64_t before_ns = thread_cpu_ns();
    state = work(state);
    const std::int64_t work_ns = thread_cpu_ns() - before_ns;
    record(out.work, work_ns);
    if (work_ns > options.period_ns) ++out.held_up;
    ++out.ticks;
    const std::int64_t skipped = late_ns / options.period_ns;
    out.skipped += static_cast<std::uint64_t>(skipped);
    due_ns += options.period_ns * (skipped + 1);
  }
}

}  // namespace

TimerMeasurement measure_timer(const TimerOptions& options) {
  auto out = std::make_unique<TimerMeasurement>();
  out->period_ns = options.period_ns;
  std::atomic<bool> go{false};
  const auto note = [&](bool granted, const char* what) {
    if (granted) return true;
    out->refused += (out->refused.empty() ? "" : "; ") + std::string(what) + ": " +
                    std::generic_category().message(errno);
    return false;
  };
  out->locked = note(lock_memory(), "locked memory");
  std::thread thread([&] { run(options, go, *out); });
  out->fifo = note(make_fifo(thread, kLoopPriority), "SCHED_FIFO");
  if (options.cpu) note(pin(thread, *options.cpu), "processor affinity");
  go.store(true, std::memory_order_release);
  thread.join();
  if (out->locked) munlockall();
  return *out;
}

}  // namespace hapticd
