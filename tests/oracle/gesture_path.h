// Where a gesture asks the handle to be, tick by tick: the player that leads the simulated arm,
// from the first way-point on, without the way there. Frame D of the device. SI. Not RT.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/math/pose.h"
#include "core/scene/scene_description.h"
#include "device/simulated/gesture.h"
#include "hapticd/v1/gesture.pb.h"

namespace hapticd {

/// X_DH of a handle that follows a track.
struct TimedPose {
  std::int64_t t_ns = 0;  ///< since the first way-point
  Pose X_DH;
};

/// Poses every `period_ns` > 0, until the rest at the last way-point is over; the last of them is
/// at that instant or up to a period later. `track` is not empty.
[[nodiscard]] std::vector<TimedPose> follow_track(const GestureTrack& track,
                                                  std::int64_t period_ns);

/// A gesture by name or file, checked, its defaults filled in; `data` as in SceneOption. Throws
/// std::runtime_error with all faults.
[[nodiscard]] v1::Gesture load_checked_gesture(const std::string& gesture, const std::string& data);

/// The motion of a tool in a gesture (the name of one in the folder, or a file), as the daemon
/// finds it. Throws std::runtime_error with all faults, also when the tool has no part in it.
[[nodiscard]] GestureMotion load_motion(const std::string& gesture, const std::string& data,
                                        const SceneDescription& scene, const ToolDescription& tool);

}  // namespace hapticd
