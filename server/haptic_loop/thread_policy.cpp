// See thread_policy.h.
#include "server/haptic_loop/thread_policy.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <array>
#include <cerrno>
#include <ctime>

namespace hapticd {

bool lock_memory() noexcept { return mlockall(MCL_CURRENT | MCL_FUTURE) == 0; }

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

void name_thread(const char* name) noexcept { pthread_setname_np(pthread_self(), name); }

[[gnu::noinline]] void prefault_stack() noexcept {
  std::array<volatile char, kStackPrefault> pages;
  for (std::size_t i = 0; i < pages.size(); i += 4096) pages[i] = 0;
}

void sleep_until(std::int64_t t_ns) noexcept {
  timespec until{};
  until.tv_sec = static_cast<time_t>(t_ns / 1'000'000'000);
  until.tv_nsec = static_cast<long>(t_ns % 1'000'000'000);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

std::int64_t thread_cpu_ns() noexcept {
  timespec used{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
  return std::int64_t{used.tv_sec} * 1'000'000'000 + used.tv_nsec;
}

}  // namespace hapticd
