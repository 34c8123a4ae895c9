// What players do to a string, on the grid of grid_string.h: the truths that sounding strings are
// judged by. SI. Not RT.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "tests/truth/grid_string.h"

namespace hapticd {

/// A string that was let go.
struct GridTone {
  double amplitude = 0.0;   ///< of mode 1 at its belly, both planes, m
  double energy = 0.0;      ///< of the string, J
  double time = 0.0;        ///< when the finger last bore force, s
  double deflection = 0.0;  ///< the largest at the finger, m
};

/// A pluck: the finger goes straight along y past the string, `height` above its axis.
struct GridPluck {
  double lambda = 0.1;
  double speed = 1.0;    ///< m/s
  double height = 3e-3;  ///< m, below the finger's radius
  GridFinger finger;
};

/// From rest until the finger is past; amplitude and energy are of the end.
[[nodiscard]] GridTone pluck(const GridString& string, const GridPluck& pluck, int cells);

/// A string pressed behind a fret by a finger, and plucked.
struct GridFret {
  double fret = 0.424;      ///< place, m from the end that sounds
  double finger = 0.474;    ///< m from there
  double below = 3e-3;      ///< of the fret under the string at rest, m
  double depth = 8.4e-3;    ///< of the finger's lowest point, m
  double pluck_at = 0.074;  ///< m
  double friction = 0.8;    ///< of the finger
};

struct GridStop {
  double frequency = 0.0;     ///< of what sounds, across the finger's push, Hz
  double fret_force = 0.0;    ///< mean while it sounds, N
  double finger_force = 0.0;  ///< N
  double tension = 0.0;       ///< N
};

/// What sounds in 0.5 s after the pluck. Without a fret where `below` is infinite.
[[nodiscard]] GridStop stop_at_fret(const GridString& string, const GridFret& fret, int cells);

/// A light touch at a node while the string is plucked, and its lift.
struct GridHarmonic {
  int part = 3;  ///< touched at node / part
  int node = 1;
  double force = 8e-3;   ///< of the touch, N: a skin of 1 mm and this many N/mm
  double damping = 0.2;  ///< of the skin, N s/m
  double pluck_lambda = 0.93;
  double pluck_speed = 1.0;  ///< m/s
  double lift_after = 0.12;  ///< s after the pluck
  double lift_speed = 0.03;  ///< m/s
};

struct GridPartials {
  double frequency = 0.0;  ///< of the harmonic, Hz
  double others = 0.0;     ///< the loudest partial that is none of it, of the harmonic's first, dB
};

/// What is left 0.1 s after the lift.
[[nodiscard]] GridPartials touch_harmonic(const GridString& string, const GridHarmonic& harmonic,
                                          int cells);

/// What a finger does over the time: where its centre is. One for each finger.
using FingerPath = std::function<FingerPlace(double time)>;

/// Goes on for `seconds` with fingers that were added before; `look` is called after each step.
void play(
    StringGrid& grid, std::span<const FingerPath> paths, double seconds,
    const std::function<void()>& look = [] {});

/// Frequency of what `signal` (one sample each `step` s) repeats most strongly near `guess` (Hz),
/// by the phase that it gains between its two halves, each under a Hann window. Within 0.01 % where
/// other partials are further off than 8 / (samples * step) Hz.
[[nodiscard]] double frequency(std::span<const double> signal, double step, double guess);

/// Force of a finger that holds the string `deflection` (m) off its axis at `lambda`, N: small
/// slopes, tension raised by E A.
[[nodiscard]] double held_force(const GridString& string, double lambda, double deflection);

}  // namespace hapticd
