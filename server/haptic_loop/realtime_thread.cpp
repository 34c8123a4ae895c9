// See realtime_thread.h.
#include "server/haptic_loop/realtime_thread.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <array>
#include <cerrno>
#include <ctime>
#include <stdexcept>
#include <system_error>

#include "core/rt/monotonic_clock.h"

namespace hapticd {
namespace {

/// Stack touched before the first tick, bytes: all that the loop uses.
constexpr std::size_t kStackPrefault = std::size_t{512} * 1024;

void sleep_until(std::int64_t t_ns) noexcept {
  timespec until{};
  until.tv_sec = static_cast<time_t>(t_ns / 1'000'000'000);
  until.tv_nsec = static_cast<long>(t_ns % 1'000'000'000);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

[[gnu::noinline]] void prefault_stack() noexcept {
  std::array<volatile char, kStackPrefault> pages;
  for (std::size_t i = 0; i < pages.size(); i += 4096) pages[i] = 0;
}

bool make_fifo(std::thread& thread, int priority) noexcept {
  sched_param parameters{};
  parameters.sched_priority = priority;
  errno = pthread_setschedparam(thread.native_handle(), SCHED_FIFO, &parameters);
  return errno == 0;
}

bool pin(std::thread& thread, std::uint32_t cpu) noexcept {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(cpu, &set);
  errno = pthread_setaffinity_np(thread.native_handle(), sizeof(set), &set);
  return errno == 0;
}

}  // namespace

void RealtimeThread::ask(bool granted, const char* what, const char* remedy) {
  if (!granted)
    missing_.push_back({std::string(what) + ": " + std::generic_category().message(errno), remedy});
}

RealtimeThread::RealtimeThread(HapticLoop& loop, const RealtimeOptions& options)
    : loop_(loop), options_(options) {
  ask(mlockall(MCL_CURRENT | MCL_FUTURE) == 0, "locked memory",
      "raise it: 'ulimit -l unlimited', or LimitMEMLOCK=infinity in the service");
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
  stop_.store(true);
  thread_.join();
  guardian_.join();
  std::string text = "realtime is required and refused:";
  for (const MissingPrivilege& missing : missing_) {
    text += "\n  " + missing.what + "; " + missing.remedy;
  }
  throw std::runtime_error(text);
}

RealtimeThread::~RealtimeThread() {
  stop_.store(true);
  if (thread_.joinable()) thread_.join();
  if (guardian_.joinable()) guardian_.join();
}

void RealtimeThread::run() noexcept {
  prefault_stack();
  const std::int64_t period_ns = options_.period_ns;
  std::int64_t due_ns = monotonic_now_ns() + period_ns;
  while (!stop_.load(std::memory_order_relaxed) && !loop_.over()) {
    sleep_until(due_ns);
    const std::int64_t now_ns = monotonic_now_ns();
    const std::int64_t late_ns = now_ns - due_ns;
    const std::uint64_t skipped =
        late_ns >= period_ns ? static_cast<std::uint64_t>(late_ns / period_ns) : 0;
    loop_.tick_once(now_ns, skipped);
    due_ns += period_ns * static_cast<std::int64_t>(skipped + 1);
  }
  over_.store(true, std::memory_order_release);
}

void RealtimeThread::guard() noexcept {
  while (!over_.load(std::memory_order_acquire) && !stop_.load(std::memory_order_relaxed)) {
    const std::int64_t now_ns = monotonic_now_ns();
    loop_.guard(now_ns);
    sleep_until(now_ns + kGuardianPeriod_ns);
  }
}

}  // namespace hapticd
