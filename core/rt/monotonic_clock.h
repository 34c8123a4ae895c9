// The time base of the daemon: CLOCK_MONOTONIC, which no clock adjustment sets back. Simulation
// never reads it; time comes to the simulation as data. RT: yes; the kernel's vDSO answers without
// a system call, about 30 ns.
#pragma once

#include <time.h>  // clock_gettime is POSIX

#include <cstdint>

namespace hapticd {

/// Nanoseconds since an arbitrary start (boot, on Linux); never decreases. Wraps in 292 years.
[[nodiscard]] inline std::int64_t monotonic_now_ns() noexcept {
  timespec now{};
  // Cannot fail: the clock exists on every Linux and the pointer is valid.
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

}  // namespace hapticd
