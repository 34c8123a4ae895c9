// From a gesture to what one device's arm is asked to do: way-points at strings are looked up in
// the scene, and the world's poses X_WH become poses X_DH of the handle through the workspace map.
// Offline.
#pragma once

#include <functional>
#include <optional>

#include "core/scene/scene_description.h"
#include "device/api/gesture_hand.h"
#include "hapticd/v1/gesture.pb.h"
#include "server/scene_io/scene_problem.h"

namespace hapticd {

/// The inverse of the workspace map: X_DH of X_WH.
using PoseToDevice = std::function<Pose(const Pose& X_WH)>;

struct MotionResult {
  /// In D. None when there is a fault, or no track of this tool, which then stays where it is.
  std::optional<GestureMotion> motion;
  SceneProblems problems;  ///< with paths below the gesture
};

/// The track of tool `tool_id` in `gesture`, which check_gesture has found sound. An orientation
/// that is not given before any other is that in which the scene's tool begins.
[[nodiscard]] MotionResult resolve_gesture(const v1::Gesture& gesture, std::uint32_t tool_id,
                                           const SceneDescription& scene,
                                           const PoseToDevice& to_device);

/// Axes of the frame at a string, as columns: x from A to B, y the world's up (its y) made normal
/// to x, z = x cross y. At an upright string y is the world's -z made so.
[[nodiscard]] Matrix3 string_frame(const Vector3& p_WA, const Vector3& p_WB);

}  // namespace hapticd
