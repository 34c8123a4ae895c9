// See clock_estimate.h.
#include "proto/wire/clock_estimate.h"

#include <algorithm>
#include <cmath>

namespace hapticd::wire {
namespace {

/// Exchanges below which no line is fitted.
constexpr std::size_t kMinPoints = 8;
/// What the slope's error is at least: quartz wanders that much within the window.
constexpr double kMinSlopeError = 1e-6;

}  // namespace

void ClockEstimate::add(const ClockSample& sample) {
  recent_[count_ % kClockSamples] = sample;
  ++count_;
  const ClockSample& chosen = best();
  if (chosen_.empty() || chosen.at_ns > chosen_.back().at_ns) chosen_.push_back(chosen);
  while (chosen_.back().at_ns - chosen_.front().at_ns > kSkewWindow_ns) chosen_.pop_front();
  fit();
}

const ClockSample& ClockEstimate::best() const noexcept {
  const auto end = recent_.begin() + static_cast<std::ptrdiff_t>(std::min(count_, kClockSamples));
  return *std::min_element(recent_.begin(), end, [](const ClockSample& a, const ClockSample& b) {
    return a.round_trip_ns < b.round_trip_ns;
  });
}

void ClockEstimate::fit() {
  line_ = {};
  const std::int64_t span = chosen_.back().at_ns - chosen_.front().at_ns;
  if (chosen_.size() < kMinPoints || span < kMinSkewWindow_ns) return;
  // Relative to the first point, so that doubles hold nanoseconds.
  const ClockSample& origin = chosen_.front();
  const auto n = static_cast<double>(chosen_.size());
  const auto x = [&](const ClockSample& s) { return static_cast<double>(s.at_ns - origin.at_ns); };
  const auto y = [&](const ClockSample& s) {
    return static_cast<double>(s.offset_ns - origin.offset_ns);
  };
  double mean_x = 0.0;
  double mean_y = 0.0;
  for (const ClockSample& s : chosen_) {
    mean_x += x(s) / n;
    mean_y += y(s) / n;
  }
  double xx = 0.0;
  double xy = 0.0;
  for (const ClockSample& s : chosen_) {
    xx += (x(s) - mean_x) * (x(s) - mean_x);
    xy += (x(s) - mean_x) * (y(s) - mean_y);
  }
  const double slope = xy / xx;
  double residual = 0.0;
  for (const ClockSample& s : chosen_) {
    const double r = y(s) - mean_y - slope * (x(s) - mean_x);
    residual += r * r;
  }
  line_.slope = std::clamp(slope, -kMaxSkew, kMaxSkew);
  line_.slope_error = kMinSlopeError + 3.0 * std::sqrt(residual / (n - 2.0) / xx);
}

ClockRelation ClockEstimate::at(std::int64_t now_ns) const {
  const ClockSample& sample = best();
  const auto age = static_cast<double>(now_ns - sample.at_ns);
  ClockRelation relation;
  relation.skew = line_.slope;
  relation.offset_ns = sample.offset_ns + std::llround(line_.slope * age);
  relation.uncertainty_ns =
      sample.round_trip_ns / 2 + 1 + std::llround(line_.slope_error * std::fabs(age));
  return relation;
}

}  // namespace hapticd::wire
