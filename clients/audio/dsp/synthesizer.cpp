// See synthesizer.h.
#include "clients/audio/dsp/synthesizer.h"

#include <algorithm>

namespace hapticd::audio {
namespace {

/// String of a voice that has been choked: nothing damps it any more.
constexpr std::int32_t kNoString = -1;
/// Gain below which a damped voice is over: 120 dB below a tone of level 1. Higher, and its end
/// would click.
constexpr double kInaudible = 2.5e-8;

}  // namespace

Synthesizer::Voice& Synthesizer::free_voice() noexcept {
  Voice* faintest = voices_.data();
  for (Voice& voice : voices_) {
    if (!voice.used) return voice;
    // What has least time left has decayed furthest.
    if (voice.gain * static_cast<double>(voice.left) <
        faintest->gain * static_cast<double>(faintest->left)) {
      faintest = &voice;
    }
  }
  ++stolen_;
  return *faintest;
}

void Synthesizer::start(const Strike& strike) noexcept {
  for (Voice& voice : voices_) {
    if (!voice.used || voice.string != strike.string) continue;
    voice.string = kNoString;
    voice.keep = strike.choke;
  }
  Voice& voice = free_voice();
  voice.used = true;
  voice.recorded = strike.recorded.samples != nullptr;
  voice.string = strike.string;
  voice.gain = strike.gain;
  voice.keep = 1.0;
  voice.share = 1.0;
  voice.ramps = 0;
  voice.left = strike.frames;
  if (voice.recorded) {
    voice.recording.start(strike);
  } else {
    voice.computed.start(strike);
  }
}

void Synthesizer::change(const Change& change) noexcept {
  for (Voice& voice : voices_) {
    if (!voice.used || voice.string != change.string) continue;
    voice.keep = change.keep;
    if (!change.bends) continue;
    if (voice.recorded) {
      voice.recording.follow(change.bend);
    } else {
      voice.computed.follow(change.bend);
    }
    voice.ramps = change.bend.approach * kGlideStep;
    voice.ramp = voice.share * (change.gain - 1.0) / voice.ramps;
  }
}

double Synthesizer::next(Voice& voice) noexcept {
  const double frame = voice.recorded ? voice.recording.next() : voice.computed.next();
  if (voice.ramps > 0) {
    voice.share += voice.ramp;
    --voice.ramps;
  }
  const double out = voice.gain * voice.share * frame;
  voice.gain *= voice.keep;
  --voice.left;
  if (voice.left <= 0 || voice.gain < kInaudible || (voice.recorded && voice.recording.over())) {
    voice.used = false;
  }
  if (is_sound(out)) return out;
  voice.used = false;
  ++broken_;
  return 0.0;
}

void Synthesizer::render(std::span<float> out) noexcept {
  for (float& frame : out) {
    double strings = 0.0;
    double recordings = 0.0;
    for (Voice& voice : voices_) {
      if (!voice.used) continue;
      (voice.recorded ? recordings : strings) += next(voice);
    }
    const double sum = body_.next(strings) + recordings;
    if (!is_sound(sum)) body_.forget();
    frame = limiter_.next(sum);
  }
}

std::size_t Synthesizer::sounding() const noexcept {
  return static_cast<std::size_t>(
      std::count_if(voices_.begin(), voices_.end(), [](const Voice& v) { return v.used; }));
}

}  // namespace hapticd::audio
