// See synthesizer.h.
#include "clients/audio/dsp/synthesizer.h"

#include <algorithm>
#include <cmath>

namespace hapticd::audio {
namespace {

/// String of a voice that has been choked: nothing damps it any more.
constexpr std::int32_t kNoString = -1;
/// Gain below which a damped voice is over: 120 dB below a tone of level 1. Higher, and its end
/// would click.
constexpr double kInaudible = 2.5e-8;
/// Share of its loudness below which a recording has been told to be silent.
constexpr double kSilentShare = 1e-9;
/// A recording is made so much louder than it is at most: 12 dB. Beyond, it is noise.
constexpr double kMostGain = 4.0;
/// A partial within 10 dB of the loudest is heard; one that has lost 12 dB against such a one above
/// it, which by itself dies away sooner, has been damped.
constexpr double kHeard = 0.3;
constexpr double kDamped = 0.25;

/// Of partial n as force at the bridge, m of the first.
double force(const ToldPartials& partials, std::size_t n) noexcept {
  return static_cast<double>(n + 1) * partials.amplitude[n];
}

/// Amplitude of a fundamental with the same energy, m.
double loudness(const ToldPartials& partials) noexcept {
  double sum = 0.0;
  for (std::size_t n = 0; n < kToldPartials; ++n) sum += force(partials, n) * force(partials, n);
  return std::sqrt(sum);
}

double keep_of_loudest(const ToldPartials& partials) noexcept {
  std::size_t loudest = 0;
  for (std::size_t n = 1; n < kToldPartials; ++n) {
    if (force(partials, n) > force(partials, loudest)) loudest = n;
  }
  return partials.keep[loudest];
}

/// For a voice of this pitch.
Bend bend_from(double log_hz, const Telling& telling) noexcept {
  Bend bend = telling.bend;
  bend.goal = std::clamp(bend.goal - log_hz, -kMaxBend, kMaxBend);
  return bend;
}

/// True where no decay leads from the partials of `began` to those of `told`: it has others, or
/// lacks low ones, as after a finger on a node.
bool lacks(const ToldPartials& began, const ToldPartials& told) noexcept {
  double loudest = 0.0;
  for (std::size_t n = 0; n < kToldPartials; ++n) loudest = std::max(loudest, force(told, n));
  for (std::size_t high = 1; high < kToldPartials; ++high) {
    if (!(force(told, high) > kHeard * loudest)) continue;
    for (std::size_t low = 0; low < high; ++low) {
      if (force(told, low) * force(began, high) < kDamped * force(told, high) * force(began, low)) {
        return true;
      }
    }
  }
  return false;
}

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

Synthesizer::Voice& Synthesizer::begin(const Strike& strike) noexcept {
  Voice& voice = free_voice();
  voice.used = true;
  voice.string = strike.string;
  voice.whole = strike.gain;
  voice.gain = strike.gain;
  voice.keep = 1.0;
  voice.share = 1.0;
  voice.ramps = 0;
  voice.left = strike.frames;
  voice.log_hz = strike.log_hz;
  voice.began = strike.partials;
  voice.loudness = loudness(strike.partials);
  voice.own_keep = strike.partials.keep[0];
  if (strike.recorded.samples != nullptr) {
    voice.kind = Kind::kRecorded;
    voice.recording.start(strike);
  } else if (strike.sines) {
    voice.kind = Kind::kPartials;
    voice.partials.start(strike);
  } else {
    voice.kind = Kind::kComputed;
    voice.computed.start(strike);
  }
  return voice;
}

void Synthesizer::start(const Strike& strike) noexcept {
  for (Voice& voice : voices_) {
    if (!voice.used || voice.string != strike.string) continue;
    voice.string = kNoString;
    voice.keep = strike.choke;
  }
  begin(strike);
}

void Synthesizer::change(const Change& change) noexcept {
  for (Voice& voice : voices_) {
    if (voice.used && voice.string == change.string) voice.keep = change.keep;
  }
}

/// False where the voice has not the partials that are told.
bool Synthesizer::follow(Voice& voice, const Strike& strike, const Telling& telling) noexcept {
  const ToldPartials& told = strike.partials;
  if (voice.kind == Kind::kComputed) return false;
  if (voice.kind == Kind::kRecorded && lacks(voice.began, told)) return false;
  const Bend bend = bend_from(voice.log_hz, telling);
  // What has damped it counts no more: from here on it goes to what is told.
  const double left = voice.whole > 0.0 ? voice.gain / voice.whole : 0.0;
  voice.gain = voice.whole;
  voice.keep = 1.0;
  if (voice.kind == Kind::kPartials) {
    voice.partials.scale(left);
    voice.partials.tell(told, bend);
    voice.left = std::max<std::int64_t>(strike.frames, bend.approach * kGlideStep + 1);
    return true;
  }
  if (told.count > 0) voice.recording.follow(bend);
  voice.share *= left;
  const double goal = std::min(loudness(told) / voice.loudness, kMostGain);
  voice.ramps = bend.approach * kGlideStep;
  voice.ramp = (goal - voice.share) / voice.ramps;
  if (told.count > 0) voice.keep = std::min(1.0, keep_of_loudest(told) / voice.own_keep);
  return true;
}

bool Synthesizer::tell(const Strike& strike, const Telling& telling) noexcept {
  bool sounds = false;
  bool follows = false;
  for (Voice& voice : voices_) {
    if (!voice.used || voice.string != strike.string) continue;
    sounds = true;
    if (follow(voice, strike, telling)) {
      follows = true;
      continue;
    }
    voice.string = kNoString;
    voice.keep = strike.choke;
  }
  if (follows || strike.partials.count == 0) return false;
  if (!sounds && !telling.begins) return false;
  Voice& voice = begin(strike);
  if (sounds) {
    voice.partials.scale(0.0);
    voice.partials.tell(strike.partials, bend_from(voice.log_hz, telling));
  }
  return !sounds;
}

double Synthesizer::sound_of(Voice& voice) noexcept {
  switch (voice.kind) {
    case Kind::kComputed:
      return voice.computed.next();
    case Kind::kPartials:
      return voice.partials.next();
    case Kind::kRecorded:
      return voice.recording.next();
  }
  return 0.0;
}

bool Synthesizer::is_over(const Voice& voice) noexcept {
  if (voice.left <= 0 || voice.gain < kInaudible) return true;
  if (voice.kind == Kind::kPartials) return voice.partials.over();
  if (voice.kind != Kind::kRecorded) return false;
  return voice.recording.over() || (voice.ramps == 0 && voice.share < kSilentShare);
}

double Synthesizer::next(Voice& voice) noexcept {
  const double frame = sound_of(voice);
  if (voice.ramps > 0) {
    voice.share += voice.ramp;
    --voice.ramps;
  }
  const double out = voice.gain * voice.share * frame;
  voice.gain *= voice.keep;
  voice.loudness *= voice.own_keep;
  --voice.left;
  if (is_over(voice)) voice.used = false;
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
      (voice.kind == Kind::kRecorded ? recordings : strings) += next(voice);
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
