// See realtime_thread.h.
#include "server/haptic_loop/realtime_thread.h"

#include <cerrno>
#include <stdexcept>
#include <system_error>

#include "core/rt/monotonic_clock.h"
#include "core/rt/thread_role.h"
#include "server/haptic_loop/thread_policy.h"
#include "server/haptic_loop/tick_pace.h"

namespace hapticd {
void RealtimeThread::ask(bool granted, const char* what, const char* remedy) {
  if (!granted)
    missing_.push_back({std::string(what) + ": " + std::generic_category().message(errno), remedy});
}

RealtimeThread::RealtimeThread(HapticLoop& loop, const RealtimeOptions& options)
    : loop_(loop), options_(options) {
  ask(lock_memory(), "locked memory",
      "raise it: 'ulimit -l unlimited', or LimitMEMLOCK=infinity in the service");
  try {
    begin();
  } catch (...) {
    end();
    throw;
  }
}

void RealtimeThread::begin() {
  thread_ = std::thread([this] { run(); });
  guardian_ = std::thread([this] { guard(); });
  ask(make_fifo(thread_, kLoopPriority), "SCHED_FIFO",
      "allow it: 'ulimit -r 90', or LimitRTPRIO=90 in the service");
  make_fifo(guardian_, kLoopPriority + 1);
  if (options_.cpu) {
    ask(pin(thread_, *options_.cpu), "processor affinity",
        "name a processor that exists with --cpu");
  }
  if (!options_.required || missing_.empty()) return;
  std::string text = "realtime is required and refused:";
  for (const MissingPrivilege& missing : missing_) {
    text += "\n  " + missing.what + "; " + missing.remedy;
  }
  throw std::runtime_error(text);
}

RealtimeThread::~RealtimeThread() { end(); }

void RealtimeThread::end() noexcept {
  stop_.store(true);
  if (thread_.joinable()) thread_.join();
  if (guardian_.joinable()) guardian_.join();
}

void RealtimeThread::run() noexcept {
  name_thread("haptic");
  prefault_stack();
  TickPace pace(options_.period_ns, options_.pace, monotonic_pace_clock());
  begin_role(ThreadRole::kHaptic);
  while (!stop_.load(std::memory_order_relaxed) && !loop_.over()) {
    const DueTick due = pace.wait();
    loop_.tick_once(due.now_ns, due.skipped);
  }
  over_.store(true, std::memory_order_release);
}

void RealtimeThread::guard() noexcept {
  name_thread("guardian");
  begin_role(ThreadRole::kGuardian);
  while (!over_.load(std::memory_order_acquire) && !stop_.load(std::memory_order_relaxed)) {
    const std::int64_t now_ns = monotonic_now_ns();
    loop_.guard(now_ns);
    sleep_until(now_ns + kGuardianPeriod_ns);
  }
}

}  // namespace hapticd
