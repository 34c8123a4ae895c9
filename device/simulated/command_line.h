// The way of commands to the simulated device: each takes effect after the declared delay, holds
// until the next one, and ends when it expires. A zero written past the loop travels the same way.
// RT: yes, except construction, O(1) per call and command.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "core/math/realtime.h"
#include "core/math/wrench.h"
#include "core/tick/device_sample.h"

namespace hapticd {

/// Commands that can be on their way: ten a millisecond over the longest delay, and as many again.
inline constexpr std::size_t kCommandsOnTheWay = 2048;

/// What the device does at an instant.
struct CommandInForce {
  Wrench F_H_D;                      ///< zero where none is valid
  bool enabled = false;              ///< motors on
  bool stale = false;                ///< the watchdog cut it: nothing came in time
  std::uint64_t sample_counter = 0;  ///< of the sample the newest command was computed from
  DeviceSpring spring;               ///< about the pose of that sample
};

class CommandLine {
 public:
  /// `delay` and `watchdog` in s; a watchdog of infinity is none. Allocates.
  CommandLine(double delay, double watchdog);

  /// Loop's thread. Sends a command at `now_ns`; false, and nothing sent, when the line is full.
  HD_REALTIME bool send(std::int64_t now_ns, const DeviceCommand& command) noexcept;

  /// Any thread. Ends all that was sent until `now_ns`.
  HD_REALTIME void send_zero(std::int64_t now_ns) noexcept;

  /// Loop's thread. What is in force at `t_ns`, which does not decrease.
  HD_REALTIME CommandInForce at(std::int64_t t_ns) noexcept;

 private:
  struct Sent {
    DeviceCommand command;
    std::int64_t sent_ns = 0;
  };
  std::int64_t delay_ns_;
  std::int64_t watchdog_ns_;
  std::vector<Sent> ring_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  Sent current_;
  bool any_ = false;
  std::atomic<std::int64_t> zero_ns_;
};

}  // namespace hapticd
