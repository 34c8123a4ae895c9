// What a string that sounds is heard as: the part of it that sounds between what stops it, its
// pitch and partials, read off its state. SI. RT: yes.
#pragma once

#include <array>

#include "core/instrument/wave_state.h"

namespace hapticd {

/// Share of the time with force that makes a stop of a touch.
inline constexpr double kStopShare = 0.9;

/// A part of a string between two stops or ends, and how it swings.
struct SoundingPart {
  double from = 0.0;  ///< along the string, [0, 1]
  double to = 1.0;
  double frequency = 0.0;                       ///< of its first partial, Hz
  double amplitude = 0.0;                       ///< of a fundamental with its energy, m
  int count = 0;                                ///< partials
  std::array<double, kMaxPartials> partials{};  ///< amplitudes, both planes together, m
  /// Of the plane that swings more, rad: partial j is A_j cos(phase_j) now. Open strings alone.
  std::array<double, kMaxPartials> phases{};
};

/// The part that sounds: the one with state.sounding.place in it, unless another is 20 dB louder. A
/// tool that has borne force nine tenths of the last time is a stop. 1 us without a stop, 3 us a
/// part with one.
[[nodiscard]] HD_REALTIME SoundingPart sounding_part(const WaveState& state,
                                                     const WaveTable& table) noexcept;

/// Pitch of the part between two stops or ends in which `place` lies, Hz; 0: none. 50 ns.
[[nodiscard]] HD_REALTIME double frequency_at(const WaveState& state, double place) noexcept;

/// Amplitude of a fundamental with `energy` (J) on a string of this tuning, m.
[[nodiscard]] HD_REALTIME double amplitude_of(const WaveTuning& tuning, double energy) noexcept;

}  // namespace hapticd
