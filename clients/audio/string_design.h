// From a tone as the daemon sends it to a strike with every coefficient: the waveguide of a string
// after Penttinen, Pakarinen, Valimaki et al., "Model-based sound synthesis of the guqin", JASA 120
// (2006). SI. Not RT: here are the sines and exponentials that the audio callback does without.
// What is ours, since the event does not say it: how much faster high partials die away, the width
// of the finger, how stiff the string is where the scene does not say, the body.
#pragma once

#include <optional>
#include <span>

#include "clients/audio/dsp/body.h"
#include "clients/audio/dsp/strike.h"

namespace hapticd::audio {

/// Root mean square of the first kLevelWindow_s of a tone of level 1, full scale 1. The peaks of
/// the seven shipped recordings of level 1 add up to 0.875: at whatever instants they are plucked,
/// their sum stays below the limiter's threshold.
inline constexpr double kLevelRms = 0.0225;
inline constexpr double kLevelWindow_s = 0.3;
/// Decay times T_d after which a tone is over: -122 dB.
inline constexpr double kLifeInDecays = 14.0;

/// Ours. At kHighFrequency_hz, or four times the fundamental if that is higher, a partial dies away
/// this many times as fast as the fundamental.
inline constexpr double kHighFrequency_hz = 2000.0;
inline constexpr double kHighDecayRatio = 6.0;
/// Ours. Inharmonicity of a string whose scene says 0: slightly stiff, as silk and wound steel are.
inline constexpr double kInharmonicity = 3e-5;
/// Ours. Half width of the finger's pulp over the length of the string.
inline constexpr double kFingerWidth = 0.004;

/// A tone as it is meant to sound.
struct ToneSound {
  int string = 0;
  double frequency_hz = 0.0;  ///< once the glide is over
  double level = 0.0;         ///< [0, 1]
  double lambda = 0.5;        ///< where it is plucked
  double decay_s = 0.5;       ///< T_d of the fundamental
  double glide_cents = 0.0;   ///< at the onset, [0, 1200]
  double glide_decay_s = 0.0;
  double inharmonicity = kInharmonicity;  ///< B: f_n = n f_1 sqrt((1 + B n^2) / (1 + B))
  double amplitude_m = 0.0;               ///< of a fundamental with its energy; 0: it is not known
  /// Amplitudes of displacement, relative to each other; none: an ideal string plucked at lambda.
  std::span<const float> partials;
};

/// What all tones share.
struct Sound {
  double rate_hz = 48000.0;
  double gain = 1.0;
  BodyFilter body;
};

/// A strike: the waveguide's, or where all its partials are given, as far as the daemon tells them,
/// these as sines. None where the pitch, glide included, does not fit into it at
/// this sample rate, or a number is out of its range.
[[nodiscard]] std::optional<Strike> design_string(const ToneSound& tone, const Sound& sound);

/// Decay time of a string's amplitude at `frequency_hz`, to 1/e, s, as its loop has it.
[[nodiscard]] double loop_decay_s(const StringLoop& loop, double frequency_hz, double rate_hz);

/// What a strike has whatever it is played by: everything but gain, loop, excitation, recording.
[[nodiscard]] Strike outline(const ToneSound& tone, const Sound& sound);

/// Amplitude of a fundamental with the energy of these partials: of partial n n times as much.
[[nodiscard]] double energy_amplitude(std::span<const float> partials);

/// Factor per frame of an amplitude that decays to 1/e in decay_s; 1 for a decay without end.
[[nodiscard]] double keep_per_frame(double decay_s, double rate_hz);

}  // namespace hapticd::audio
