// See gesture_target.h.
#include "tests/fuzz/gesture_target.h"

#include <cmath>
#include <stdexcept>

#include "device/simulated/gesture.h"
#include "server/scene_io/gesture_motion.h"
#include "tests/server/scene_io/inline_text.h"

namespace hapticd::test {
namespace {

void require(bool condition) {
  if (!condition)
    throw std::logic_error("a gesture was taken that cannot be played, or refused without reason");
}

/// A tool and a few strings, one of them upright.
SceneDescription small_scene() {
  SceneDescription scene;
  scene.tools.resize(1);
  scene.strings.resize(4);
  for (std::size_t i = 0; i < scene.strings.size(); ++i) {
    scene.strings[i].parameters.p_WA = {0.0, 0.0, 0.01 * static_cast<double>(i)};
    scene.strings[i].parameters.p_WB = {i == 3 ? 0.0 : 1.0, i == 3 ? 1.0 : 0.0, 0.01};
  }
  return scene;
}

}  // namespace

bool check_gesture_bytes(std::span<const std::uint8_t> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const GestureResult result = load_gesture_text(text);
  if (!result.gesture) {
    require(any_fault(result.problems));
    for (const SceneProblem& problem : result.problems) require(!problem.message.empty());
    return false;
  }
  const MotionResult resolved =
      resolve_gesture(*result.gesture, 0, small_scene(), [](const Pose& X_WH) { return X_WH; });
  require(resolved.motion.has_value() || any_fault(resolved.problems) ||
          result.gesture->tracks_size() > 0);
  if (!resolved.motion) return true;
  GesturePlayer player(Pose{});
  player.play(resolved.motion->track(), 2);
  for (int i = 0; i < 200; ++i) {
    const Pose& X_DH = player.advance(std::int64_t{1} << (i % 40));
    require(std::abs(X_DH.q.norm() - 1.0) < 1e-9);
    require(X_DH.p.norm() < 1e8);
    const GestureProgress progress = player.progress();
    require(progress.fraction >= 0.0F && progress.fraction <= 1.0F && progress.finished <= 2);
  }
  return true;
}

}  // namespace hapticd::test
