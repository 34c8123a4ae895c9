// A gesture of a study played through the core's own simulation in this process, tick by tick: what
// it gave, what work it was, and what the exhaustive search says of its way. SI, frame W. Not RT.
#pragma once

#include <limits>
#include <vector>

#include "tests/oracle/baseline.h"
#include "tests/oracle/study_gesture.h"
#include "tests/oracle/study_setting.h"
#include "tests/truth/path_run.h"

namespace hapticd {

/// Processor time of this thread, us: what else the machine does is not a cost of a tick.
[[nodiscard]] double processor_time();

struct StudyTick {
  Vector3 felt_W{0.0, 0.0, 0.0};     ///< force on the hand before ramps and limits, N
  Vector3 contact_W{0.0, 0.0, 0.0};  ///< of it, the contact problem's: nothing that vibrates
  Vector3 torque_W{0.0, 0.0, 0.0};   ///< N m
  Pose X_WG;
  bool touches = false;
  OptimiserResult counts;
  double cpu_us = 0.0;  ///< processor time of this thread
  /// Smallest on the committed way; no number where it was not judged, nor while a tool that began
  /// inside of something, as in a scene of fatter spheres, has not been out yet.
  double path_gap_m = std::numeric_limits<double>::quiet_NaN();
};

/// Plays `gesture` with `setting` on `scene`, which has the setting's strings already. `judge`, of
/// the same scene and tool, or null: every way is searched, too, which must lead bit for bit to the
/// same poses; throws std::logic_error where it does not.
[[nodiscard]] std::vector<StudyTick> play_study(const Scene& scene, std::size_t tool,
                                                const StudySetting& setting,
                                                const StudyGesture& gesture, PathRun* judge);

/// The same by another method (baseline.h); it counts nothing but time.
[[nodiscard]] std::vector<StudyTick> play_baseline(const Scene& scene, std::size_t tool,
                                                   BaselineMethod method,
                                                   const StudyGesture& gesture, PathJudge& judge);

}  // namespace hapticd
