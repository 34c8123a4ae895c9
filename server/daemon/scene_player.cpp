// See scene_player.h.
#include "server/daemon/scene_player.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "device/simulated/device_factory.h"
#include "server/haptic_loop/settings_change.h"
#include "server/scene_io/gesture_motion.h"

namespace hapticd {
namespace {

/// The numbers the safety stage wants, from the profile.
SafetyLimits limits_of(const PlayerOptions& options) {
  const DeviceProfile& profile = options.profile.profile;
  SafetyLimits limits;
  limits.peak = {std::min(profile.peak_force, options.max_force), profile.peak_torque};
  limits.continuous_force = profile.continuous_force;
  limits.continuous_torque = profile.continuous_torque;
  limits.thermal_window_s = profile.thermal_window;
  limits.passivity.acceleration = profile.acceleration_max;
  limits.passivity.damping = profile.damping;
  limits.passivity.rotational_damping =
      *std::min_element(profile.rotational_damping.begin(), profile.rotational_damping.end());
  return limits;
}

StiffnessLimits stiffness_limits_of(const PlayerOptions& options) {
  const DeviceProfile& profile = options.profile.profile;
  StiffnessLimits limits;
  limits.damping = profile.damping;
  limits.rotational_damping =
      *std::min_element(profile.rotational_damping.begin(), profile.rotational_damping.end());
  limits.stiffness_max = std::isfinite(profile.stiffness_max) ? profile.stiffness_max : 0.0;
  limits.period_s = 1e-9 * static_cast<double>(options.period_ns);
  limits.delay_s = profile.delay;
  return limits;
}

PlayedDevice make_played_device(const PlayerOptions& options, const Pose& X_DH) {
  PlayedDevice played;
  if (options.source == "scripted") {
    ScriptedOptions scripted;
    scripted.p_DH = to_array(X_DH.p);
    scripted.q_DH = to_array(X_DH.q);
    scripted.hold = options.virtual_time;
    played.owned = make_device(options.profile.profile, scripted);
    played.scripted = dynamic_cast<ScriptedDevice*>(played.owned.get());
  } else {
    SimulatedOptions simulated;
    simulated.X_DH = X_DH;
    simulated.arm = options.arm;
    simulated.seed = options.seed;
    played.owned = make_device(options.profile.profile, simulated);
    played.simulated = dynamic_cast<SimulatedDevice*>(played.owned.get());
  }
  if (options.injection) {
    Injection injection = *options.injection;
    injection.period_ns = options.period_ns;
    played.owned = std::make_unique<FaultyDevice>(std::move(played.owned), injection);
  }
  played.device = played.owned.get();
  return played;
}

/// Where the gesture's hand is before it moves.
std::optional<Pose> begin_of(const GesturePlan* gesture) {
  if (gesture == nullptr) return std::nullopt;
  const GestureTrack track = gesture->motion.track();
  if (track.empty()) return std::nullopt;
  const GesturePoint& point = track.legs.empty() ? track.samples.front() : track.legs.front().point;
  return Pose{to_quaternion(point.q_DH), to_vector(point.p_DH)};
}

}  // namespace

void follow_config(const v1::Config& config, PlayerOptions& options) {
  options.arm = static_cast<ArmKind>(config.arm());
  options.seed = config.seed();
  options.max_force = config.has_max_force() ? config.max_force() : kUnlimited;
}

std::unique_ptr<GesturePlan> plan_gesture(const v1::Gesture& gesture, const LoadedScene& scene) {
  const SceneDescription& description = scene.scene->description();
  const ToolDescription& tool = description.tools.front();
  const WorkspaceMap& map = tool.workspace;
  MotionResult result = resolve_gesture(gesture, tool.tool_id, description, [&](const Pose& X_WH) {
    return to_device(map, WorkspaceState{}, X_WH);
  });
  if (any_fault(result.problems)) {
    const auto fault = std::find_if(result.problems.begin(), result.problems.end(),
                                    [](const SceneProblem& problem) { return !problem.doubt; });
    const std::string text = "gesture " + gesture.name() + " does not fit: " + fault->field + ": " +
                             fault->message + " " + fault->remedy;
    throw std::runtime_error(text);
  }
  auto plan = std::make_unique<GesturePlan>();
  const std::size_t length = std::min(gesture.name().size(), kGestureNameCapacity);
  std::copy_n(gesture.name().begin(), length, plan->name.begin());
  if (result.motion) plan->motion = std::move(*result.motion);
  return plan;
}

std::unique_ptr<PlayedScene> make_played_scene(std::shared_ptr<const LoadedScene> loaded,
                                               std::uint32_t scene_id,
                                               std::unique_ptr<GesturePlan> gesture,
                                               const PlayerOptions& options) {
  const Scene& scene = *loaded->scene;
  const SceneDescription& description = scene.description();
  if (description.tools.size() != kPlayableTools) {
    throw std::runtime_error("scene " + description.name + " has " +
                             std::to_string(description.tools.size()) +
                             " tools: this version plays one. Leave the others out.");
  }
  const ToolDescription& tool = description.tools.front();
  auto played = std::make_unique<PlayedScene>();
  played->scene_id = scene_id;
  played->play = scene.simulate(0);
  played->tool_id = tool.tool_id;
  played->map = tool.workspace;
  played->X_WG_home = tool.X_WG;
  played->limits = limits_of(options);
  played->stiffness_limits = stiffness_limits_of(options);
  played->settings = scene_settings(description, 0);
  played->strings.resize(played->settings.pieces.size());
  played->play.simulation->scene(0).strings = played->strings;
  const Pose home = to_device(played->map, WorkspaceState{}, tool.X_WG);
  played->device = make_played_device(options, begin_of(gesture.get()).value_or(home));
  played->gesture = std::move(gesture);
  apply_settings(*played);
  played->scene = std::shared_ptr<const Scene>(std::move(loaded), &scene);
  return played;
}

}  // namespace hapticd
