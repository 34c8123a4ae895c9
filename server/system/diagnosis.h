// From what a machine is and how it kept time to what is wrong with it: each cause with the command
// that fixes it. A pure function of facts, so that every verdict can be tested. Not RT.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/system/host_facts.h"
#include "server/system/timer_measurement.h"

namespace hapticd {

enum class Verdict : std::uint8_t {
  kGood,
  kHint,   ///< may cost time; the loop can live with it
  kCause,  ///< makes ticks late, or keeps the daemon from what it needs
};

/// One thing looked at.
struct Finding {
  Verdict verdict = Verdict::kGood;
  std::string name;  ///< short, for programs: "memlock"
  std::string what;  ///< for people
  std::string fix;   ///< command; empty where nothing is to be done
};

/// All that was learned.
struct HostReport {
  HostFacts facts;
  HostCounters before;
  HostCounters after;
  TimerMeasurement timer;
  double seconds = 0.0;              ///< measured; 0: facts alone
  std::optional<std::uint32_t> cpu;  ///< processor asked for
};

/// Locked memory the daemon has to be granted, bytes. Normal value 1 GiB, above what it maps with a
/// large scene; where less is granted it cannot lock what it maps later.
inline constexpr std::int64_t kLockedBytes = std::int64_t{1} << 30;
/// Slowest wake-up of an idle processor that is put up with, us: a twentieth of a tick of 1 ms.
inline constexpr std::int64_t kIdleLatency_us = 50;
/// Share of time that a hypervisor may take away: more makes ticks late by whole periods.
inline constexpr double kStealAllowed = 1e-3;
/// Share of a period that a tick's work may take beyond its median: more, and the machine stops
/// threads that run.
inline constexpr double kHoldUpAllowed = 0.5;
/// Interrupts of devices on the loop's processor that are put up with, 1/s: each costs some us.
inline constexpr double kInterruptsAllowed = 100.0;
/// Share of time the processors are busy above which others wait for the same ones.
inline constexpr double kBusyAllowed = 0.8;

/// One finding for each thing that could be looked at, in a fixed order.
[[nodiscard]] std::vector<Finding> diagnose(const HostReport& report);

/// No cause among them.
[[nodiscard]] bool fit(const std::vector<Finding>& findings) noexcept;

}  // namespace hapticd
