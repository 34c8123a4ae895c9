// See recorded_voice.h.
#include "clients/audio/dsp/recorded_voice.h"

#include "clients/audio/dsp/interpolation.h"

namespace hapticd::audio {

void RecordedVoice::start(const Strike& strike) noexcept {
  recorded_ = strike.recorded;
  glide_ = strike.glide;
  place_ = 0.0;
  step_ = recorded_.step * glide_.ratio();
  age_ = 0;
}

double RecordedVoice::next() noexcept {
  if (over()) return 0.0;
  const auto whole = static_cast<std::int64_t>(place_);
  const auto weights = tap_weights(place_ - static_cast<double>(whole));
  double sum = 0.0;
  for (int k = 0; k < kTaps; ++k) {
    const std::int64_t at = whole + k - kTapsBefore;
    if (at < 0 || at >= recorded_.frames) continue;
    sum += weights[static_cast<std::size_t>(k)] * static_cast<double>(recorded_.samples[at]);
  }
  place_ += step_;
  if (glide_.active() && ++age_ % kGlideStep == 0) {
    glide_.advance();
    step_ = recorded_.step * glide_.ratio();
  }
  return sum;
}

}  // namespace hapticd::audio
