// The gestures of deploy/gestures, in a scene. Not RT.
#pragma once

#include <string>

#include "core/scene/scene_description.h"
#include "server/scene_io/gesture_motion.h"

namespace hapticd::test {

/// One of them as the first tool plays it, poses in W; fails the test when there is none or the
/// scene lacks what it names.
[[nodiscard]] GestureMotion shipped_gesture(const std::string& name, const SceneDescription& scene);

}  // namespace hapticd::test
