// What of the strings' physics a scene models, and how. What is off costs nothing. Names and ranges
// are those of scene.proto. RT: plain data.
#pragma once

#include <cstdint>
#include <optional>

#include "core/instrument/parameter_range.h"
#include "core/math/realtime.h"

namespace hapticd {

/// What a tone's level is proportional to.
enum class ToneLevel : std::uint8_t {
  kAmplitude,  ///< the amplitude that rings on after the release
  /// |F_d| (the paper): the largest of the touch, for the last before a finger rolls off is nearly
  /// 0 and a matter of where the ticks fall. Of a wave, the force at the amplitude that rings on.
  kForce,
};

/// When a touched string counts as plucked.
struct ReleaseOptions {
  /// Deflection that arms it, m, (0, 0.1]. Smaller: encoder noise plucks.
  double arm_deflection = 0.3e-3;
  /// Gap after which a lost contact is a release, m, (0, 0.1].
  double release_gap = 0.1e-3;
  /// Time after a release in which another only raises it, s, [0, 1].
  double refractory = 0.02;
};

struct ToneOptions {
  bool enabled = true;
  ToneLevel level = ToneLevel::kAmplitude;
  double reference_amplitude = 5e-3;  ///< level 1, m, (0, 1]; louder is clipped
  double reference_force = 1.0;       ///< level 1, N, (0, 1e3]; louder is clipped
  double gain = 1.0;                  ///< factor on the level before it is clipped, [0, 100]
};

struct InstrumentOptions {
  bool vibration = true;       ///< a released string rings; off: it is still at once
  bool pitch_glide = false;    ///< f(a) = f_1 pitch_factor(lambda, a)
  double sleep_energy = 1e-4;  ///< share of the energy at release below which it sleeps, (0, 0.1]
  int modes = 0;               ///< modes per string, [0, 64]; 0: the fundamental alone
  int substeps = 32;           ///< of a millisecond, of modes: 8, 16, 32 or 64
  bool friction = false;       ///< Coulomb friction with a stick anchor per object
  double anchor_stiffness = 1e4;  ///< of that anchor, N/m, [1e-3, 1e9]
  bool lateral_force = false;     ///< axial force of strings that do not yield; others have it
  /// Largest acceleration of a held tool, m/s^2, (0, 1e6]: bounds how much work the vibration may
  /// do in a tick.
  double max_acceleration = 500.0;
  ReleaseOptions release;
  ToneOptions tones;
};

/// The first fault of `options`, none when all is well. Non-finite numbers are out of range. Fields
/// are named by their path in Scene, such as "release.refractory_s"; the one that scenes do not set
/// by the name it has here. 35 ns.
[[nodiscard]] HD_REALTIME std::optional<ParameterFault> check_options(
    const InstrumentOptions& options) noexcept;

}  // namespace hapticd
