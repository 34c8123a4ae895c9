// The server's clock relative to this one: PROTOCOL.md, section 7. The offset of the smallest
// round trip of the last eight exchanges, carried on with the skew that least squares over 30 s
// give. Pure; times are ns. Not RT.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>

#include "proto/wire/clock_exchange.h"

namespace hapticd::wire {

/// Exchanges among which the one with the smallest round trip is believed.
inline constexpr std::size_t kClockSamples = 8;
/// Time the skew is estimated over, ns, and below which it is taken to be 0: shorter, the jitter of
/// a round trip looks like skew.
inline constexpr std::int64_t kSkewWindow_ns = 30'000'000'000;
inline constexpr std::int64_t kMinSkewWindow_ns = 5'000'000'000;
/// Skew no pair of machines exceeds: what an offset may have drifted by while the skew is unknown.
inline constexpr double kMaxSkew = 500e-6;

/// The relation at one instant.
struct ClockRelation {
  std::int64_t offset_ns = 0;       ///< server's clock minus own clock, at the instant asked for
  double skew = 0.0;                ///< its growth per time of this clock; 1e-6 = 1 ppm
  std::int64_t uncertainty_ns = 0;  ///< of the offset
};

/// Collects exchanges.
class ClockEstimate {
 public:
  /// One answered exchange, in the order of arrival.
  void add(const ClockSample& sample);
  /// Any exchange has been answered.
  [[nodiscard]] bool known() const noexcept { return count_ > 0; }
  /// The relation at `now_ns` of this clock; only when known().
  [[nodiscard]] ClockRelation at(std::int64_t now_ns) const;
  /// The smallest round trip of the last eight exchanges, ns; only when known().
  [[nodiscard]] std::int64_t round_trip_ns() const { return best().round_trip_ns; }

 private:
  struct Line {
    double slope = 0.0;
    double slope_error = kMaxSkew;  ///< three standard errors
  };

  [[nodiscard]] const ClockSample& best() const noexcept;
  void fit();

  std::array<ClockSample, kClockSamples> recent_{};
  std::size_t count_ = 0;
  std::deque<ClockSample> chosen_;  ///< the best of eight, as they changed, over 30 s
  Line line_;
};

}  // namespace hapticd::wire
