// The clock of the haptic loop: a thread that calls tick_once() on time, and the guardian that
// looks at it. SCHED_FIFO, locked and prefaulted memory, one processor; ticks come by the timer or
// by a device (tick_pace.h), and one that is late skips the periods it missed. Linux. The loop's
// body is RT, starting and stopping are not.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "device/api/pace_source.h"
#include "server/haptic_loop/haptic_loop.h"

namespace hapticd {

/// Time between two looks of the guardian, ns.
inline constexpr std::int64_t kGuardianPeriod_ns = 1'000'000;

/// What is asked of the machine.
struct RealtimeOptions {
  std::int64_t period_ns = 1'000'000;
  PaceSource pace;                   ///< none: the timer. Must outlive the thread
  bool required = false;             ///< a missing privilege ends the start
  std::optional<std::uint32_t> cpu;  ///< processor to run on; none: any
};

/// A privilege the machine refused.
struct MissingPrivilege {
  std::string what;    ///< "SCHED_FIFO: Operation not permitted"
  std::string remedy;  ///< the command that gives it
};

/// Runs a loop until it is over or this is destroyed.
class RealtimeThread {
 public:
  /// Starts. Throws std::runtime_error naming each missing privilege and its remedy when one is
  /// missing and required. `loop` must outlive this.
  RealtimeThread(HapticLoop& loop, const RealtimeOptions& options);
  RealtimeThread(const RealtimeThread&) = delete;
  RealtimeThread& operator=(const RealtimeThread&) = delete;
  ~RealtimeThread();

  /// What the machine refused; empty when all was granted.
  [[nodiscard]] const std::vector<MissingPrivilege>& missing() const noexcept { return missing_; }

  /// True once the loop is over, or was told to stop.
  [[nodiscard]] bool over() const noexcept { return over_.load(std::memory_order_acquire); }

 private:
  void begin();
  void end() noexcept;
  void run() noexcept;
  void guard() noexcept;
  void ask(bool granted, const char* what, const char* remedy);

  HapticLoop& loop_;
  RealtimeOptions options_;
  std::vector<MissingPrivilege> missing_;
  std::atomic<bool> stop_{false};
  std::atomic<bool> over_{false};
  std::thread guardian_;
  std::thread thread_;
};

}  // namespace hapticd
