// See body_design.h.
#include "clients/audio/body_design.h"

#include <array>
#include <cmath>
#include <complex>
#include <numbers>

namespace hapticd::audio {
namespace {

struct Resonance {
  double frequency_hz;
  double width_hz;  ///< at 3 dB
  double height;    ///< beside the direct sound's 1
};

/// Ours.
constexpr std::array<Resonance, kBodyModes> kResonances{{{95.0, 14.0, 0.9},
                                                         {168.0, 18.0, 0.8},
                                                         {251.0, 24.0, 0.7},
                                                         {372.0, 32.0, 0.6},
                                                         {540.0, 45.0, 0.5},
                                                         {810.0, 70.0, 0.4}}};

}  // namespace

BodyFilter design_body(double rate_hz) {
  BodyFilter body;
  for (std::size_t i = 0; i < kBodyModes; ++i) {
    const Resonance& resonance = kResonances[i];
    const double omega = 2.0 * std::numbers::pi * resonance.frequency_hz / rate_hz;
    const double alpha = 0.5 * std::sin(omega) * resonance.width_hz / resonance.frequency_hz;
    body.modes[i] = {resonance.height * alpha / (1.0 + alpha),
                     -2.0 * std::cos(omega) / (1.0 + alpha), (1.0 - alpha) / (1.0 + alpha)};
  }
  return body;
}

double body_gain(const BodyFilter& body, double omega) {
  const std::complex<double> z = std::polar(1.0, -omega);
  std::complex<double> sum = 1.0;
  for (const BodyMode& mode : body.modes) {
    sum += mode.b * (1.0 - z * z) / (1.0 + mode.a1 * z + mode.a2 * z * z);
  }
  return std::abs(sum);
}

}  // namespace hapticd::audio
