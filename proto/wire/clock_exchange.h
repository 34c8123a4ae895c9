// The exchange of instants that relates two clocks: PROTOCOL.md, section 7. Not RT.
#pragma once

#include <cstdint>
#include <optional>

#include "hapticd/v1/stream.pb.h"

namespace hapticd::wire {

/// The answering side: remembers the newest Clock received and answers it once.
class ClockEcho {
 public:
  /// A Clock of the peer arrived at now_ns. Only one that was sent later than those before counts.
  void take(const v1::Clock& clock, std::int64_t now_ns) {
    if (clock.sent_ns() == 0 || (any_ && clock.sent_ns() <= sent_ns_)) return;
    any_ = true;
    pending_ = true;
    sent_ns_ = clock.sent_ns();
    received_ns_ = now_ns;
  }

  /// Puts the answer into a Packet that leaves at now_ns, if one is owed.
  void fill(v1::Packet& packet, std::int64_t now_ns) {
    if (!pending_) return;
    pending_ = false;
    v1::Clock& clock = *packet.mutable_clock();
    clock.set_echoed_ns(sent_ns_);
    clock.set_received_ns(static_cast<std::uint64_t>(received_ns_));
    clock.set_sent_ns(static_cast<std::uint64_t>(now_ns));
  }

 private:
  bool any_ = false;
  bool pending_ = false;
  std::uint64_t sent_ns_ = 0;
  std::int64_t received_ns_ = 0;
};

/// What one answered Clock says.
struct ClockSample {
  std::int64_t at_ns = 0;          ///< own clock, middle of the exchange
  std::int64_t offset_ns = 0;      ///< the peer's clock minus this one
  std::int64_t round_trip_ns = 0;  ///< >= 0; |error of the offset| <= half of it
};

/// The sample in `clock`, received at now_ns of this side's clock; nothing when it answers nothing
/// or its times contradict each other.
[[nodiscard]] inline std::optional<ClockSample> clock_sample(const v1::Clock& clock,
                                                             std::int64_t now_ns) {
  /// Instants beyond 2^61 ns (73 years) are refused, so that no sum overflows.
  constexpr std::uint64_t kLatest_ns = std::uint64_t{1} << 61U;
  if (clock.echoed_ns() == 0 || clock.echoed_ns() > kLatest_ns ||
      clock.received_ns() > kLatest_ns || clock.sent_ns() > kLatest_ns || now_ns < 0 ||
      now_ns > static_cast<std::int64_t>(kLatest_ns)) {
    return std::nullopt;
  }
  const auto t0 = static_cast<std::int64_t>(clock.echoed_ns());
  const auto t1 = static_cast<std::int64_t>(clock.received_ns());
  const auto t2 = static_cast<std::int64_t>(clock.sent_ns());
  const std::int64_t round_trip = (now_ns - t0) - (t2 - t1);
  if (now_ns < t0 || t2 < t1 || round_trip < 0) return std::nullopt;
  return ClockSample{t0 + (now_ns - t0) / 2, ((t1 - t0) + (t2 - now_ns)) / 2, round_trip};
}

}  // namespace hapticd::wire
