// See string_voice.h.
#include "clients/audio/dsp/string_voice.h"

#include <algorithm>

namespace hapticd::audio {
namespace {

/// Of the line, as a ring.
constexpr std::uint32_t kMask = 8191;

}  // namespace

void StringVoice::start(const Strike& strike) noexcept {
  loop_ = strike.loop;
  glide_ = strike.glide;
  line_.fill(0.0);
  section_in_.fill(0.0);
  section_out_.fill(0.0);
  loss_ = 0.0;
  now_ = 0;
  delay_step_ = 0.0;
  set_delay(delay_of(glide_.ratio()));

  const Excitation& excitation = strike.excitation;
  excitation_frames_ = static_cast<std::uint32_t>(excitation.frames);
  partials_ = excitation.partials;
  // cos and sin of n theta, one after the other by the addition theorem.
  double cosine = 1.0;
  double sine = 0.0;
  for (std::size_t n = 0; n < static_cast<std::size_t>(partials_); ++n) {
    const double next_cosine = cosine * excitation.cosine - sine * excitation.sine;
    sine = sine * excitation.cosine + cosine * excitation.sine;
    cosine = next_cosine;
    const double amplitude = static_cast<double>(excitation.amplitude[n]);
    sine_[n] = 0.0;
    before_[n] = -amplitude * sine;
    turn_[n] = 2.0 * cosine;
  }
}

double StringVoice::delay_of(double ratio) const noexcept {
  return std::clamp(loop_.period / ratio - loop_.filter_delay, kMinDelay, kMaxPeriod);
}

void StringVoice::set_delay(double delay) noexcept {
  delay_ = delay;
  whole_ = static_cast<std::uint32_t>(delay) + 1;
  weights_ = tap_weights(static_cast<double>(whole_) - delay);
}

void StringVoice::follow_glide() noexcept {
  if (now_ % kGlideStep == 0) {
    if (!glide_.active()) {
      delay_step_ = 0.0;
      set_delay(delay_of(glide_.ratio()));
      return;
    }
    glide_.advance();
    delay_step_ = (delay_of(glide_.ratio()) - delay_) / kGlideStep;
  }
  set_delay(delay_ + delay_step_);
}

double StringVoice::excite() noexcept {
  double sum = 0.0;
  for (std::size_t n = 0; n < static_cast<std::size_t>(partials_); ++n) {
    sum += sine_[n];
    const double next = turn_[n] * sine_[n] - before_[n];
    before_[n] = sine_[n];
    sine_[n] = next;
  }
  return sum;
}

double StringVoice::delayed() const noexcept {
  const std::uint32_t first = now_ - whole_ - kTapsBefore;
  double sum = 0.0;
  for (std::uint32_t k = 0; k < kTaps; ++k) sum += weights_[k] * line_[(first + k) & kMask];
  return sum;
}

double StringVoice::next() noexcept {
  if (glide_.active() || delay_step_ != 0.0) follow_glide();
  double signal = delayed();
  for (std::size_t s = 0; s < static_cast<std::size_t>(loop_.sections); ++s) {
    const double out = loop_.dispersion * (signal - section_out_[s]) + section_in_[s];
    section_in_[s] = signal;
    section_out_[s] = out;
    signal = out;
  }
  loss_ = loop_.loss_gain * signal - loop_.loss_pole * loss_;
  const double out = now_ < excitation_frames_ ? loss_ + excite() : loss_;
  line_[now_ & kMask] = out;
  ++now_;
  return out;
}

}  // namespace hapticd::audio
