// What the guardian decides, which checks the loop's heartbeat from a separate thread: a loop
// that is stuck leaves a force frozen, and a frozen force turns active (a spring of 1 kN/m
// after 12.6 ms). It writes zero once and remembers. Pure; the thread belongs to the haptic loop.
// RT: yes.
#pragma once

#include <cstdint>

namespace hapticd {

/// Age of the heartbeat at which the guardian acts, ns. Longer: more energy from a frozen force
/// (2 mJ at 5 ms, 190 mJ at 50 ms); shorter: fires on what an ordinary kernel does.
inline constexpr std::int64_t kStall_ns = 5'000'000;

/// Kept by the guardian's thread.
struct Guardian {
  bool fired = false;           ///< zero was written for the present stall
  std::uint64_t stalls = 0;     ///< stalls seen
  std::int64_t longest_ns = 0;  ///< oldest heartbeat seen while armed
};

/// True exactly once for each stall: the caller then writes a zero wrench and reports kGuardian. A
/// stall ends when a heartbeat is fresh again. `armed`: a force may be on and time is real. A
/// heartbeat in the future counts as fresh.
[[nodiscard]] constexpr bool must_write_zero(std::int64_t heartbeat_ns, std::int64_t now_ns,
                                             bool armed, Guardian& guardian) noexcept {
  const std::int64_t age_ns = now_ns > heartbeat_ns ? now_ns - heartbeat_ns : 0;
  if (!armed || age_ns <= kStall_ns) {
    guardian.fired = false;
    return false;
  }
  if (age_ns > guardian.longest_ns) guardian.longest_ns = age_ns;
  if (guardian.fired) return false;
  guardian.fired = true;
  ++guardian.stalls;
  return true;
}

}  // namespace hapticd
