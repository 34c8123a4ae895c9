// See gesture_path.h.
#include "tests/oracle/gesture_path.h"

#include <filesystem>
#include <stdexcept>
#include <utility>

#include "core/simulation/workspace_map.h"
#include "server/scene_io/gesture_loader.h"
#include "server/scene_io/gesture_motion.h"

namespace hapticd {
std::vector<TimedPose> follow_track(const GestureTrack& track, std::int64_t period_ns) {
  const GesturePoint& first = track.legs.empty() ? track.samples.front() : track.legs.front().point;
  GesturePlayer player(Pose{to_quaternion(first.q_DH), to_vector(first.p_DH)});
  player.play(track, 1);
  std::vector<TimedPose> poses;
  std::int64_t t_ns = 0;
  poses.push_back({t_ns, player.advance(0)});
  while (player.progress().playing) {
    t_ns += period_ns;
    poses.push_back({t_ns, player.advance(period_ns)});
  }
  return poses;
}

v1::Gesture load_checked_gesture(const std::string& gesture, const std::string& data) {
  const GestureFolders folders = data.empty()
                                     ? installed_gestures()
                                     : GestureFolders{std::filesystem::path(data) / "gestures"};
  GestureResult loaded = load_gesture(gesture, folders);
  if (!loaded.gesture) throw std::runtime_error(faults_text(loaded.problems));
  return std::move(*loaded.gesture);
}

GestureMotion load_motion(const std::string& gesture, const std::string& data,
                          const SceneDescription& scene, const ToolDescription& tool) {
  const WorkspaceMap& map = tool.workspace;
  MotionResult result =
      resolve_gesture(load_checked_gesture(gesture, data), tool.tool_id, scene,
                      [&map](const Pose& X_WH) { return to_device(map, WorkspaceState{}, X_WH); });
  if (any_fault(result.problems)) {
    throw std::runtime_error(gesture + " does not fit the scene " + scene.name + ":\n" +
                             faults_text(result.problems));
  }
  if (!result.motion || result.motion->track().empty()) {
    throw std::runtime_error(gesture + " has no track of tool " + std::to_string(tool.tool_id) +
                             ". Name another with --tool");
  }
  return std::move(*result.motion);
}

}  // namespace hapticd
