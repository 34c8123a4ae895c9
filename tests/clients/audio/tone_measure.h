// Measures sounds without knowing how they were made: a sine is taken out of a sound by a Hann
// window and a complex exponential, as every spectrum analyser does. The truth that the synthesiser
// is held against.
#pragma once

#include <cmath>
#include <complex>
#include <numbers>
#include <span>

namespace hapticd::test {

/// The complex amplitude of the sine of `frequency_hz` in a window of `length_s` from `begin_s` on,
/// phase at the start of the sound.
inline std::complex<double> sine_in(std::span<const float> sound, double rate_hz,
                                    double frequency_hz, double begin_s, double length_s) {
  const auto first = static_cast<std::size_t>(begin_s * rate_hz);
  const auto size = static_cast<std::size_t>(length_s * rate_hz);
  const double omega = 2.0 * std::numbers::pi * frequency_hz / rate_hz;
  std::complex<double> sum = 0.0;
  double weights = 0.0;
  for (std::size_t i = 0; i < size && first + i < sound.size(); ++i) {
    const double weight = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * static_cast<double>(i) /
                                               static_cast<double>(size));
    sum += weight * static_cast<double>(sound[first + i]) *
           std::polar(1.0, -omega * static_cast<double>(first + i));
    weights += weight;
  }
  return 2.0 * sum / weights;
}

/// The frequency of the sine near `guess_hz`: how its phase advances between two windows of
/// `length_s` that begin `apart_s` after each other. Right while guess and truth differ by less
/// than 1 / (2 apart_s).
inline double frequency_near(std::span<const float> sound, double rate_hz, double guess_hz,
                             double begin_s, double length_s, double apart_s) {
  double frequency_hz = guess_hz;
  for (int turn = 0; turn < 3; ++turn) {
    const auto early = sine_in(sound, rate_hz, frequency_hz, begin_s, length_s);
    const auto late = sine_in(sound, rate_hz, frequency_hz, begin_s + apart_s, length_s);
    frequency_hz += std::arg(late / early) / (2.0 * std::numbers::pi * apart_s);
  }
  return frequency_hz;
}

/// Decay time of the sine's amplitude, to 1/e, s.
inline double decay_near(std::span<const float> sound, double rate_hz, double frequency_hz,
                         double begin_s, double length_s, double apart_s) {
  const auto early = sine_in(sound, rate_hz, frequency_hz, begin_s, length_s);
  const auto late = sine_in(sound, rate_hz, frequency_hz, begin_s + apart_s, length_s);
  return apart_s / std::log(std::abs(early) / std::abs(late));
}

/// Root mean square from begin_s on, over length_s.
inline double rms(std::span<const float> sound, double rate_hz, double begin_s, double length_s) {
  const auto first = static_cast<std::size_t>(begin_s * rate_hz);
  const auto size = static_cast<std::size_t>(length_s * rate_hz);
  double sum = 0.0;
  for (const float frame : sound.subspan(first, size))
    sum += static_cast<double>(frame) * static_cast<double>(frame);
  return std::sqrt(sum / static_cast<double>(size));
}

inline double cents(double frequency_hz, double reference_hz) {
  return 1200.0 * std::log2(frequency_hz / reference_hz);
}

}  // namespace hapticd::test
