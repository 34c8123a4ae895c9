// What /proc, /sys and /dev say about a machine's fitness for a loop of 1 kHz: read, not judged.
// What is not there stays unknown; nothing needs a privilege. Linux. Not RT.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace hapticd {

/// Where to look, so that tests can give their own tree.
struct ProbeRoot {
  std::filesystem::path root = "/";
  /// Whether this process may read and write a file; empty: ask the kernel.
  std::function<bool(const std::filesystem::path&)> may_use;
};

/// A state of a processor that has nothing to do.
struct IdleState {
  std::string name;
  std::int64_t latency_us = 0;  ///< to wake up
  std::string number;           ///< of its folder, "2"
};

/// A device that speaks HID.
struct HidrawAccess {
  std::string file;  ///< /dev/hidraw0
  std::string name;  ///< as the device gives it
  bool usable = false;
};

/// The present state. Absent or empty: not known.
struct HostFacts {
  std::string processor;                    ///< model
  std::vector<int> processors;              ///< online
  std::map<std::string, int> governors;     ///< processors by governor
  std::optional<IdleState> slowest_idle;    ///< of those that are not disabled
  std::optional<std::int64_t> dma_latency;  ///< longest latency that is put up with, us
  bool hypervisor = false;
  std::string clock_source;
  std::vector<std::string> clock_sources;  ///< available
  std::string kernel;                      ///< version
  bool realtime_kernel = false;            ///< PREEMPT_RT
  std::optional<std::int64_t> rt_runtime_us;
  std::optional<std::int64_t> rt_period_us;
  std::optional<std::int64_t> highest_priority;  ///< of SCHED_FIFO, 99 with the capability
  std::optional<std::int64_t> lockable_bytes;    ///< kNoLimit with the capability
  std::vector<HidrawAccess> hidraw;
};

/// HostFacts::lockable_bytes without a limit.
inline constexpr std::int64_t kNoLimit = INT64_MAX;

/// Counters that grow; two readings show what happened between them.
struct HostCounters {
  std::int64_t steal = 0;  ///< clock ticks of all processors, taken by the hypervisor
  std::int64_t idle = 0;   ///< clock ticks of all processors
  std::int64_t all = 0;    ///< clock ticks of all processors
  /// Interrupts of devices on one processor, by "NUMBER NAME".
  std::map<std::string, std::int64_t> interrupts;
};

/// Reads what does not change.
[[nodiscard]] HostFacts read_facts(const ProbeRoot& root);

/// Reads what counts; interrupts of processor `cpu`, none where absent.
[[nodiscard]] HostCounters read_counters(const ProbeRoot& root, std::optional<std::uint32_t> cpu);

}  // namespace hapticd
