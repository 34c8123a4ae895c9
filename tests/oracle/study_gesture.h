// Motions that a study of accuracy is made over: each presses a place of a scene, drawn by a seed,
// slides and turns on it at a stated speed, and lets go. Smooth in time and given at any instant,
// so that it can be sampled at any rate; the same numbers on every machine. Frames: W. SI. Not RT.
#pragma once

#include <cstdint>

#include "core/scene/scene.h"
#include "tests/truth/path_judge.h"

namespace hapticd {

/// Time a study's gesture takes, s.
inline constexpr double kStudyGesture_s = 0.4;

struct StudyGesture {
  Pose X_WH_touch;  ///< where the tool touches first, coming along -n_W
  Vector3 n_W{0.0, 1.0, 0.0};
  Vector3 slide_W{0.0, 0.0, 0.0};  ///< amplitude of the slide, m
  Vector3 cross_W{0.0, 0.0, 0.0};  ///< of the slower one across it, m
  Vector3 turn_W{0.0, 0.0, 0.0};   ///< amplitude of the rotation vector, rad
  double slide_hz = 1.0;
  double cross_hz = 1.0;
  double turn_hz = 1.0;
  double depth = 0.0;  ///< pressed in, m

  /// X_WH at `t` in [0, kStudyGesture_s]; before and after, as at the ends.
  [[nodiscard]] Pose at(double t) const;
};

/// The gesture number `seed` of tool number `tool`, whose peak speed along the surface is about
/// `speed` (m/s). Throws std::runtime_error where the tool finds no place it can come to.
[[nodiscard]] StudyGesture choose_study_gesture(const Scene& scene, std::size_t tool,
                                                PathJudge& judge, std::uint64_t seed, double speed);

}  // namespace hapticd
