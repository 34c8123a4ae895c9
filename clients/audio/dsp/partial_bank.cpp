// See partial_bank.h.
#include "clients/audio/dsp/partial_bank.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hapticd::audio {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
/// A partial fades out from here to there as its frequency rises, shares of the sample rate.
constexpr double kFades = 0.43;
constexpr double kGone = 0.45;

/// Inaudible by 500 dB: made exactly 0, since numbers below 1e-308 are slow; looked for after so
/// many frames.
constexpr double kSilent = 1e-25;
constexpr std::uint32_t kSettleEvery = 1024;

/// Frequency of partial n over n f; of the first it is 1.
double stretch(double inharmonicity, double n) noexcept {
  return std::sqrt((1.0 + inharmonicity * n * n) / (1.0 + inharmonicity));
}

/// base^count, count >= 0.
double power(double base, int count) noexcept {
  double result = 1.0;
  for (; count > 0; count /= 2) {
    if (count % 2 != 0) result *= base;
    base *= base;
  }
  return result;
}

double audible(double omega) noexcept {
  return std::clamp((kGone - omega / kTurn) / (kGone - kFades), 0.0, 1.0);
}

}  // namespace

Turn turn_by(double angle) noexcept {
  const double x = 0.25 * angle;
  const double square = x * x;
  double cosine = 1.0;
  double sine = 1.0;
  for (int k = 16; k > 0; k -= 2) {
    cosine = 1.0 - cosine * square / (k * (k - 1));
    sine = 1.0 - sine * square / (k * (k + 1));
  }
  sine *= x;
  for (int twice = 0; twice < 2; ++twice) {
    const double doubled = 2.0 * sine * cosine;
    cosine = cosine * cosine - sine * sine;
    sine = doubled;
  }
  return {cosine, sine};
}

double PartialBank::omega_of(std::size_t n, double ratio) const noexcept {
  return std::min(number_[n] * omega_ * ratio, kGone * kTurn);
}

void PartialBank::start(const Strike& strike) noexcept {
  const ToldPartials& told = strike.partials;
  glide_ = strike.glide;
  omega_ = told.omega;
  per_metre_ = strike.per_metre;
  silent_ = false;
  turns_ = false;
  ramp_ = ramps_ = 0;
  stretches_ = 0;
  age_ = 0;
  for (std::size_t n = 0; n < kToldPartials; ++n) {
    const auto number = static_cast<double>(n + 1);
    number_[n] = number * stretch(told.inharmonicity, number);
    amplitude_[n] = per_metre_ * number * told.amplitude[n];
    keep_[n] = told.keep[n];
    cosine_[n] = 1.0;
    sine_[n] = 0.0;
  }
  retune();
}

void PartialBank::tell(const ToldPartials& told, const Bend& bend) noexcept {
  silent_ = told.count == 0;
  ramp_ = 0;
  ramps_ = bend.approach * kGlideStep;
  if (!silent_) glide_.follow(bend);
  stretches_ = silent_ ? 0 : bend.approach;
  for (std::size_t n = 0; n < kToldPartials; ++n) {
    const auto number = static_cast<double>(n + 1);
    from_[n] = amplitude_[n];
    goal_[n] = per_metre_ * number * told.amplitude[n] * power(told.keep[n], ramps_);
    keep_[n] = told.keep[n];
    if (silent_) continue;
    number_step_[n] = (number * stretch(told.inharmonicity, number) - number_[n]) / stretches_;
  }
}

void PartialBank::scale(double factor) noexcept {
  for (double& amplitude : amplitude_) amplitude *= factor;
}

void PartialBank::retune() noexcept {
  const double ratio = glide_.ratio();
  PerPartial now{};
  for (std::size_t n = 0; n < kToldPartials; ++n) {
    now[n] = omega_of(n, ratio);
    const Turn rate = turn_by(now[n]);
    rate_cosine_[n] = rate.cosine;
    rate_sine_[n] = rate.sine;
    audible_[n] = audible(now[n]);
  }
  turns_ = glide_.active() || stretches_ > 0;
  if (!turns_) return;
  glide_.advance();
  const double then = glide_.ratio();
  for (std::size_t n = 0; n < kToldPartials; ++n) {
    if (stretches_ > 0) number_[n] += number_step_[n];
    const Turn curve = turn_by((omega_of(n, then) - now[n]) / kGlideStep);
    curve_cosine_[n] = curve.cosine;
    curve_sine_[n] = curve.sine;
  }
  if (stretches_ > 0) --stretches_;
}

void PartialBank::advance() noexcept {
  for (std::size_t n = 0; n < kToldPartials; ++n) {
    const double cosine = cosine_[n] * rate_cosine_[n] - sine_[n] * rate_sine_[n];
    sine_[n] = sine_[n] * rate_cosine_[n] + cosine_[n] * rate_sine_[n];
    cosine_[n] = cosine;
  }
  if (turns_) {
    for (std::size_t n = 0; n < kToldPartials; ++n) {
      const double cosine = rate_cosine_[n] * curve_cosine_[n] - rate_sine_[n] * curve_sine_[n];
      rate_sine_[n] = rate_sine_[n] * curve_cosine_[n] + rate_cosine_[n] * curve_sine_[n];
      rate_cosine_[n] = cosine;
    }
  }
  if (ramp_ < ramps_) {
    const double way = static_cast<double>(++ramp_) / ramps_;
    const double share = way * way * (3.0 - 2.0 * way);
    for (std::size_t n = 0; n < kToldPartials; ++n) {
      amplitude_[n] = from_[n] + share * (goal_[n] - from_[n]);
    }
  } else {
    for (std::size_t n = 0; n < kToldPartials; ++n) amplitude_[n] *= keep_[n];
  }
}

void PartialBank::settle() noexcept {
  for (double& amplitude : amplitude_) {
    if (amplitude < kSilent) amplitude = 0.0;
  }
}

double PartialBank::next() noexcept {
  double sum = 0.0;
  for (std::size_t n = 0; n < kToldPartials; ++n) {
    sum += audible_[n] * amplitude_[n] * sine_[n];
  }
  advance();
  if (++age_ % kSettleEvery == 0) settle();
  if (age_ % kGlideStep == 0 && (turns_ || glide_.active() || stretches_ > 0)) retune();
  return sum;
}

}  // namespace hapticd::audio
