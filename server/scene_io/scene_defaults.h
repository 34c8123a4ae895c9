// Fills in what a scene leaves out, so that the message says all that is played: what SceneInfo
// shows, and what is translated. Features that are absent stay absent, but for the wave of what
// vibrates. Offline.
#pragma once

#include <optional>

#include "hapticd/v1/scene.pb.h"

namespace hapticd {

/// Half of the tick of 1 ms, us.
inline constexpr double kUsualBudget_us = 500.0;

/// What of quality is decided outside a scene.
struct QualityWish {
  std::optional<v1::Quality> quality;        ///< replaces the scene's
  std::optional<double> budget_us;           ///< of automatic quality; replaces the scene's
  double usual_budget_us = kUsualBudget_us;  ///< where none is given: half the tick
};

/// Puts `wish` into `scene`; solver settings that the scene gives are kept. Before fill_defaults.
void choose_quality(const QualityWish& wish, v1::Scene& scene);

/// Sets every absent number, choice and pose of `scene` to its default. `preset`, where given,
/// replaces the scene's and every field a preset decides, set or not.
void fill_defaults(std::optional<v1::Preset> preset, v1::Scene& scene);

/// Sets the frequency of every string with TUNING_TENSION to that of its density under its tension;
/// none where that is not in the range of frequency_hz.
void follow_tension(v1::Scene& scene);

/// Modes per string that `scene` asks for, by wave or by modes; 0: none. Its defaults are filled
/// in.
[[nodiscard]] int modes_of(const v1::Scene& scene);

/// Sets an absent position to 0 and an absent orientation to the identity.
void fill_pose(v1::Pose& pose);

/// The usual level, where `quality` has no choice.
void fill_quality(v1::Quality& quality);

/// The knobs that `quality` decides, where `solver` does not give them.
void fill_knobs(const v1::Quality& quality, v1::Solver& solver);

/// The rung of the ladder of core/scene/quality.h that `quality` asks for; automatic quality begins
/// with the usual one.
[[nodiscard]] int quality_level(const v1::Quality& quality);

}  // namespace hapticd
