// See shipped_gesture.h.
#include "tests/scenario/shipped_gesture.h"

#include <doctest/doctest.h>

#include <utility>

#include "server/scene_io/gesture_loader.h"

namespace hapticd::test {

GestureMotion shipped_gesture(const std::string& name, const SceneDescription& scene) {
  const GestureResult gesture = load_gesture(name, {HAPTICD_SOURCE_DIR "/deploy/gestures"});
  REQUIRE(gesture.gesture.has_value());
  MotionResult result =
      resolve_gesture(*gesture.gesture, 0, scene, [](const Pose& X_WH) { return X_WH; });
  REQUIRE(result.motion.has_value());
  return std::move(*result.motion);
}

}  // namespace hapticd::test
