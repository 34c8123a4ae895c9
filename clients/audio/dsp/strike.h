// One tone, ready to be played: every coefficient that needs sines and exponentials has been worked
// out by string_design.h before it comes here. Times in frames (samples) of the output. RT: plain
// data, trivially copyable.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "clients/audio/dsp/glide.h"

namespace hapticd::audio {

/// Partials that a plucked string begins with.
inline constexpr int kMaxPartials = 64;
/// Of these, partials that the daemon tells one by one.
inline constexpr int kToldPartials = 12;
/// Allpass sections of the dispersion.
inline constexpr int kMaxSections = 8;
/// Longest period of a string, frames: 6 Hz at 48 kHz, 24 Hz at 192 kHz.
inline constexpr double kMaxPeriod = 8000.0;
/// Shortest way through the delay line itself, frames: the interpolation needs as many.
inline constexpr double kMinDelay = 5.0;

/// The loop of a waveguide string: y = x + loss(dispersion(y, `period` - filters later)).
struct StringLoop {
  double period = 0.0;  ///< of the fundamental once the glide is over, frames
  /// Phase delay of loss and dispersion there, frames. A glide of an octave changes it by 0.2
  /// cents.
  double filter_delay = 0.0;
  double loss_gain = 0.0;   ///< b of b / (1 + a z^-1)
  double loss_pole = 0.0;   ///< a, in (-1, 0]
  double dispersion = 0.0;  ///< c of (c + z^-1) / (1 + c z^-1), in (-1, 0]
  int sections = 0;         ///< how many of these
};

/// What a string is plucked with: one period of a sum of sines.
struct Excitation {
  std::array<float, kMaxPartials> amplitude{};  ///< of partial n + 1
  int partials = 0;
  double cosine = 1.0;  ///< of 2 pi over the period at the onset
  double sine = 0.0;    ///< of the same
  int frames = 0;       ///< of that period, rounded up
};

/// A recorded tone. The samples outlive all voices.
struct RecordedTone {
  const float* samples = nullptr;  ///< null: the string is computed
  std::int64_t frames = 0;
  double step = 1.0;  ///< frames of the recording per frame of the output, once the glide is over
};

/// What the first partials of a string do from an instant on.
struct ToldPartials {
  int count = 0;               ///< 0: it is silent
  double omega = 0.0;          ///< of the first, rad per frame
  double inharmonicity = 0.0;  ///< B: partial n at n omega sqrt((1 + B n^2) / (1 + B))
  std::array<double, kToldPartials> amplitude{};  ///< m
  std::array<double, kToldPartials> keep{};       ///< factor per frame
};

/// The note it is for instruments that speak MIDI.
struct MidiNote {
  std::uint8_t channel = 0;   ///< 0..15
  std::uint8_t number = 0;    ///< 0..127
  std::uint8_t velocity = 0;  ///< 1..127
};

/// All of it.
struct Strike {
  std::int32_t string = 0;  ///< index in the scene
  double gain = 0.0;        ///< factor on what the voice computes
  double choke = 0.0;       ///< factor per frame on an older tone of the same string
  Glide glide;              ///< at the onset
  std::int64_t frames = 0;  ///< after which it has died away
  MidiNote note;
  StringLoop loop;
  Excitation excitation;
  RecordedTone recorded;
  bool sines = false;      ///< played as `partials`, by neither loop nor recording
  ToldPartials partials;   ///< as it begins
  double per_metre = 0.0;  ///< of the voice, for a gain of 1, per metre of the first partial
  double log_hz = 0.0;     ///< ln of its pitch once the glide is over
};

/// A string that sounds is damped, or rings freely again.
struct Change {
  std::int32_t string = 0;
  double keep = 1.0;  ///< factor per frame, beyond the tone's own decay; 1: it rings freely
};

/// How a string goes to the partials of a strike that is told while it sounds.
struct Telling {
  Bend bend;               ///< of its pitch; the goal as ln of Hz, reached with the amplitudes
  bool begins = false;     ///< where nothing sounds, it begins
  bool ends_note = false;  ///< it is so soft, or damped, that its note is over
};

static_assert(std::is_trivially_copyable_v<Strike>, "it crosses a thread");

}  // namespace hapticd::audio
