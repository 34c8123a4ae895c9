// See resampling.h.
#include "clients/audio/resampling.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace hapticd::audio {
namespace {

/// Zero crossings of the sinc on each side. More, and the band that is kept grows towards Nyquist.
constexpr int kCrossings = 80;
/// Points of the table per crossing; the straight line between two errs by 1e-6. Of four times as
/// many the processor's cache would not hold the table.
constexpr int kPoints = 1024;
/// Of the Kaiser window: 110 dB.
constexpr double kBeta = 11.3;
/// Cut-off over the lower Nyquist frequency: the middle of the band in which the filter closes,
/// which ends at Nyquist.
constexpr double kCutOff = 0.955;

/// The modified Bessel function of order 0.
double bessel_i0(double x) {
  double sum = 1.0;
  double term = 1.0;
  for (int k = 1; term > 1e-17 * sum; ++k) {
    term *= 0.25 * x * x / (static_cast<double>(k) * k);
    sum += term;
  }
  return sum;
}

/// One half of the windowed sinc, from its middle on.
std::vector<double> make_table() {
  std::vector<double> table(std::size_t{kCrossings} * kPoints + 2);
  const double middle = bessel_i0(kBeta);
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double x = static_cast<double>(i) / kPoints;
    const double share = x / kCrossings;
    if (share >= 1.0) continue;
    const double angle = std::numbers::pi * x;
    const double sinc = i == 0 ? 1.0 : std::sin(angle) / angle;
    table[i] = sinc * bessel_i0(kBeta * std::sqrt(1.0 - share * share)) / middle;
  }
  return table;
}

/// The windowed sinc `x` crossings from its middle, x >= 0.
double at(const std::vector<double>& table, double x) {
  const double place = x * kPoints;
  const auto whole = static_cast<std::size_t>(place);
  if (whole + 1 >= table.size()) return 0.0;
  return table[whole] + (place - static_cast<double>(whole)) * (table[whole + 1] - table[whole]);
}

}  // namespace

std::vector<float> resampled(std::span<const float> samples, int from_hz, int to_hz) {
  if (from_hz == to_hz) return {samples.begin(), samples.end()};
  static const std::vector<double> table = make_table();
  const auto size = static_cast<std::int64_t>(samples.size());
  // Crossings per frame of the input.
  const double scale = kCutOff * std::min(1.0, static_cast<double>(to_hz) / from_hz);
  const auto reach = static_cast<std::int64_t>(kCrossings / scale) + 1;
  std::vector<float> out(static_cast<std::size_t>((size * to_hz + from_hz - 1) / from_hz));
  for (std::size_t n = 0; n < out.size(); ++n) {
    const std::int64_t place = static_cast<std::int64_t>(n) * from_hz;
    const std::int64_t whole = place / to_hz;
    const double rest = static_cast<double>(place % to_hz) / to_hz;
    const std::int64_t first = std::max<std::int64_t>(whole - reach, 0);
    const std::int64_t last = std::min(whole + reach + 1, size - 1);
    double sum = 0.0;
    for (std::int64_t k = first; k <= last; ++k) {
      const double away = std::abs(static_cast<double>(k - whole) - rest);
      sum += static_cast<double>(samples[static_cast<std::size_t>(k)]) * at(table, away * scale);
    }
    out[n] = static_cast<float>(scale * sum);
  }
  return out;
}

}  // namespace hapticd::audio
