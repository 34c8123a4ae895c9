// The ranges of what a scene models of its strings. See instrument_options.h. RT: yes.
#include "core/instrument/instrument_options.h"

#include <array>

#include "core/math/limits.h"

namespace hapticd {
namespace {

/// One number with its range.
struct Entry {
  const char* field;
  double value;
  ParameterRange range;
  const char* remedy;
};

/// What is not a range.
std::optional<ParameterFault> check_choices(const InstrumentOptions& options) noexcept {
  if (options.modes > 0 && !options.vibration) {
    return ParameterFault{"modes.count", static_cast<double>(options.modes), "0 without vibration",
                          "Add vibration to the scene, or leave modes out."};
  }
  const int substeps = options.substeps;
  if (substeps != 8 && substeps != 16 && substeps != 32 && substeps != 64) {
    return ParameterFault{"wave.substeps", static_cast<double>(substeps), "8, 16, 32 or 64",
                          "Give one of them; 32 is usual, fewer are cheaper."};
  }
  if (options.tones.level != ToneLevel::kAmplitude && options.tones.level != ToneLevel::kForce) {
    return ParameterFault{"tones.level", static_cast<double>(options.tones.level),
                          "amplitude or force", "Choose what the level follows."};
  }
  return std::nullopt;
}

}  // namespace

std::optional<ParameterFault> check_options(const InstrumentOptions& options) noexcept {
  static_assert(kMaxModes == 64,
                "the range of modes.count is written out below and in scene.proto");
  const ReleaseOptions& release = options.release;
  const ToneOptions& tones = options.tones;
  const std::array<Entry, 10> entries{{
      {"vibration.sleep_energy",
       options.sleep_energy,
       {0.0, 0.1, false, "(0, 0.1]"},
       "Give a share of the energy at release; 1e-4 is usual."},
      {"modes.count",
       static_cast<double>(options.modes),
       {0.0, kMaxModes, true, "[0, 64]"},
       "Give the number of modes per string; 0 is the fundamental alone."},
      {"friction.anchor_stiffness_n_per_m",
       options.anchor_stiffness,
       {1e-3, 1e9, true, "[1e-3, 1e9]"},
       "Give the stiffness of the stick anchor; 10 times the coupling's is usual."},
      {"max_acceleration",
       options.max_acceleration,
       {0.0, 1e6, false, "(0, 1e6]"},
       "Give the largest acceleration of a held device; 500 is usual."},
      {"tones.reference_amplitude_m",
       tones.reference_amplitude,
       {0.0, 1.0, false, "(0, 1]"},
       "Give the amplitude of level 1 in metres; 0.005 is usual."},
      {"tones.reference_force_n",
       tones.reference_force,
       {0.0, 1e3, false, "(0, 1e3]"},
       "Give the force of level 1 in newtons; 1 is usual."},
      {"tones.gain",
       tones.gain,
       {0.0, 100.0, true, "[0, 100]"},
       "Give a factor on the level; 1 leaves it as it is."},
      {"release.arm_deflection_m",
       release.arm_deflection,
       {0.0, 0.1, false, "(0, 0.1]"},
       "Give a deflection in metres above the device's noise; 3e-4 is usual."},
      {"release.release_gap_m",
       release.release_gap,
       {0.0, 0.1, false, "(0, 0.1]"},
       "Give a gap in metres above the device's noise; 1e-4 is usual."},
      {"release.refractory_s",
       release.refractory,
       {0.0, 1.0, true, "[0, 1]"},
       "Give a time in seconds; 0.02 is usual."},
  }};
  for (const Entry& entry : entries) {
    if (!contains(entry.range, entry.value)) {
      return ParameterFault{entry.field, entry.value, entry.range.text, entry.remedy};
    }
  }
  return check_choices(options);
}

}  // namespace hapticd
