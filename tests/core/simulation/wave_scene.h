// What the tests of strings that sound share: a string without stretch, one tool over it, and the
// force that it feels.
#pragma once

#include <cstdint>

#include "tests/core/simulation/simulation_fixture.h"
#include "tests/support/fresh_seed.h"

namespace hapticd::test {

/// Strings sound by 32 modes.
[[nodiscard]] InstrumentOptions wave_options();

/// One string of Instrument and how it is held.
struct WaveScene {
  double tension = 30.0;         ///< N
  double frequency = 65.4;       ///< Hz
  double axial_stiffness = 0.0;  ///< E A, N
  double decay = 0.5;            ///< s
  double kt = 1000.0;            ///< N/m
  double friction = 0.0;         ///< mu; 0: off
  double tip = kFingertip;       ///< radius of the tool, m

  [[nodiscard]] StringParameters string() const;
  /// Of the tool's centre from the string's axis where they touch, m.
  [[nodiscard]] double reach() const { return tip + string().radius; }
};

/// One tool over the string, which sounds, or, with `sounds` off, keeps to its static law.
[[nodiscard]] Instrument wave_instrument(const WaveScene& scene, bool sounds = true);

/// Force of everything on the tool in the last tick, before limits, N.
[[nodiscard]] Vector3 felt_force(const Instrument& instrument);

}  // namespace hapticd::test
