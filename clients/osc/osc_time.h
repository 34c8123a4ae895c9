// When an OSC message should take effect: the daemon's clock, by way of this machine's, as
// the time of day that OSC's time tags count from 1900. Pure. Not RT.
#pragma once

#include <cstdint>
#include <optional>

namespace hapticd::osc {

/// A time tag: seconds since 1900 and fraction of a second in 2^-32.
struct TimeTag {
  std::uint32_t seconds = 0;
  std::uint32_t fraction = 0;

  friend bool operator==(const TimeTag&, const TimeTag&) = default;
};

/// OSC's word for at once.
inline constexpr TimeTag kImmediately{0, 1};

/// The tag of an instant of the time of day, ns since 1970.
[[nodiscard]] TimeTag tag_of(std::int64_t unix_ns);

/// The clocks at one instant.
struct Clocks {
  std::int64_t monotonic_ns = 0;  ///< own clock
  std::int64_t unix_ns = 0;       ///< time of day at the same instant
  std::optional<std::int64_t>
      daemon_minus_ns;  ///< the daemon's clock minus this one; nothing: unknown
};

/// What became of an instant.
struct Schedule {
  TimeTag tag = kImmediately;
  bool late = false;  ///< its time had passed
};

/// When what happened at `t_ns` of the daemon's clock is to be heard, `delay_ns` after it. At once
/// where the delay is 0, where it has no instant, and where the clock is not known.
[[nodiscard]] Schedule schedule(std::uint64_t t_ns, std::int64_t delay_ns, const Clocks& clocks);

}  // namespace hapticd::osc
