// See scene_player.h.
#include "server/daemon/scene_player.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "device/simulated/device_factory.h"
#include "server/scene_io/gesture_motion.h"

namespace hapticd {
namespace {

/// The numbers the safety stage wants, from the profile. What the profile does not limit is no
/// limit there either.
SafetyLimits limits_of(const PlayerOptions& options) {
  const DeviceProfile& profile = options.profile.profile;
  const auto or_none = [](double limit) { return std::isfinite(limit) ? limit : 0.0; };
  SafetyLimits limits;
  limits.peak = {std::min(profile.peak_force, options.max_force), profile.peak_torque};
  limits.continuous_force = or_none(profile.continuous_force);
  limits.continuous_torque = or_none(profile.continuous_torque);
  limits.thermal_window_s = profile.thermal_window;
  limits.passivity.acceleration = profile.acceleration_max;
  limits.passivity.damping = profile.damping;
  limits.passivity.rotational_damping =
      *std::min_element(profile.rotational_damping.begin(), profile.rotational_damping.end());
  return limits;
}

/// Clamps the stiffness of what plays to what the device bears.
void grant(const PlayerOptions& options, const ToolDescription& tool, PlayedScene& played) {
  const DeviceProfile& profile = options.profile.profile;
  ToolScene& scene = played.play.simulation->scene();
  const double to_device = played.map.scale * played.force_gain;
  DeviceStiffness wanted;
  wanted.kt = scene.stiffness.kt * to_device;
  wanted.kr = scene.stiffness.kr() * played.force_gain;
  for (const StringConstants& string : played.strings) {
    wanted.kc = std::max(wanted.kc, std::min(string.contact_stiffness, scene.stiffness.kt));
  }
  wanted.kc *= to_device;
  StiffnessLimits limits;
  limits.damping = profile.damping;
  limits.rotational_damping =
      *std::min_element(profile.rotational_damping.begin(), profile.rotational_damping.end());
  limits.coupling_damping = tool.coupling_damping;
  limits.stiffness_max = std::isfinite(profile.stiffness_max) ? profile.stiffness_max : 0.0;
  limits.period_s = 1e-9 * static_cast<double>(options.period_ns);
  limits.delay_s = profile.delay;
  played.delay = profile.delay;
  played.grant = grant_stiffness(wanted, limits);
  // Where poses come from data, force moves nothing and no stiffness is too high.
  if (follows_data(played.device.device->profile().driver)) played.grant.scale = 1.0;
  scene.stiffness.kt *= played.grant.scale;
  for (StringConstants& string : played.strings) string.contact_stiffness *= played.grant.scale;
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
  played->force_gain = tool.force_gain;
  played->limits = limits_of(options);
  const ToolScene& view = played->play.simulation->scene();
  played->strings.assign(view.strings.begin(), view.strings.end());
  played->play.simulation->scene().strings = played->strings;
  played->play.simulation->scene().coupling_damping = tool.coupling_damping;
  const Pose home = to_device(played->map, WorkspaceState{}, tool.X_WG);
  played->device = make_played_device(options, begin_of(gesture.get()).value_or(home));
  played->gesture = std::move(gesture);
  grant(options, tool, *played);
  played->scene = std::shared_ptr<const Scene>(std::move(loaded), &scene);
  return played;
}

}  // namespace hapticd
