// A tone as sound, for tests: designed and rendered without an engine.
#pragma once

#include <doctest/doctest.h>

#include <memory>
#include <vector>

#include "clients/audio/body_design.h"
#include "clients/audio/dsp/synthesizer.h"
#include "clients/audio/string_design.h"

namespace hapticd::test {

/// No body: the string alone.
inline audio::Sound bare(double rate_hz = 48000.0) { return {rate_hz, 1.0, {}}; }
/// As it is played.
inline audio::Sound whole(double rate_hz = 48000.0) {
  return {rate_hz, 1.0, audio::design_body(rate_hz)};
}

inline std::vector<float> played(const audio::Strike& strike, const audio::Sound& sound,
                                 double length_s) {
  const auto synthesizer = std::make_unique<audio::Synthesizer>(sound.body);
  std::vector<float> frames(static_cast<std::size_t>(sound.rate_hz * length_s));
  synthesizer->start(strike);
  synthesizer->render(frames);
  return frames;
}

inline std::vector<float> played(const audio::ToneSound& tone, const audio::Sound& sound,
                                 double length_s) {
  const auto strike = audio::design_string(tone, sound);
  REQUIRE(strike);
  return played(*strike, sound, length_s);
}

/// A pluck near the bridge, of half the full level, that rings for a while.
inline audio::ToneSound tone_of(double frequency_hz) {
  audio::ToneSound tone;
  tone.frequency_hz = frequency_hz;
  tone.level = 0.5;
  tone.lambda = 0.13;
  tone.decay_s = 1.0;
  return tone;
}

}  // namespace hapticd::test
