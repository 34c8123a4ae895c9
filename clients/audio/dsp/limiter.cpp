// See limiter.h.
#include "clients/audio/dsp/limiter.h"

namespace hapticd::audio {
namespace {

/// Gain nearer to 1 than this is 1: 1e-7 dB.
constexpr double kWhole = 1e-8;

/// The loudness that leaves for one above the threshold: a hyperbola that goes on from the straight
/// line with its slope and stays below 1.
double knee(double size) noexcept {
  constexpr double kRoom = 1.0 - kLimiterThreshold;
  const double beyond = (size - kLimiterThreshold) / kRoom;
  return kLimiterThreshold + kRoom * beyond / (1.0 + beyond);
}

}  // namespace

float Limiter::next(double in) noexcept {
  if (!is_sound(in)) return 0.0F;
  gain_ += (1.0 - gain_) * kLimiterRecovery;
  if (1.0 - gain_ < kWhole) gain_ = 1.0;
  const double size = in < 0.0 ? -in : in;
  if (size > kLimiterThreshold) {
    const double allowed = knee(size) / size;
    if (allowed < gain_) gain_ = allowed;
  }
  if (gain_ < 1.0) ++limited_;
  return static_cast<float>(gain_ * in);
}

}  // namespace hapticd::audio
