// From a session with the daemon to OSC: what is sent when, and what is counted. Not RT.
#pragma once

#include <cstdint>
#include <functional>

#include "clients/osc/osc_message.h"
#include "clients/osc/osc_time.h"
#include "proto/wire/clock_estimate.h"

namespace hapticd::osc {

/// What happened so far.
struct BridgeCounters {
  std::uint64_t sent = 0;
  std::uint64_t late = 0;    ///< of them, after their time
  std::uint64_t unsent = 0;  ///< that the system did not take
};

class Bridge {
 public:
  using Send = std::function<bool(const OscMessage&, const TimeTag&)>;

  /// Everything is heard `delay_ns` after it happened; 0: as soon as it is there.
  Bridge(std::int64_t delay_ns, Send send) : delay_ns_(delay_ns), send_(std::move(send)) {}

  void item(const v1::Item& item, const Clocks& clocks);
  void state(const v1::State& state, const Clocks& clocks);
  [[nodiscard]] const BridgeCounters& counters() const noexcept { return counters_; }

 private:
  void send(const OscMessage& message, const Clocks& clocks);

  std::int64_t delay_ns_;
  Send send_;
  BridgeCounters counters_;
};

/// The clocks of this machine now, and the daemon's as `estimate` knows it. A virtual clock does
/// not follow time: with `virtual_clock` the daemon's is left out.
[[nodiscard]] Clocks clocks_now(const wire::ClockEstimate& estimate, bool virtual_clock);

}  // namespace hapticd::osc
