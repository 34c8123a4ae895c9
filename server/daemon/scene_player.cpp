// See scene_player.h.
#include "server/daemon/scene_player.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "server/daemon/work_cost.h"
#include "server/haptic_loop/device_limits.h"
#include "server/haptic_loop/settings_change.h"
#include "server/scene_io/gesture_motion.h"

namespace hapticd {
namespace {

/// The numbers the safety stage wants, from the profile.
SafetyLimits limits_of(const DeviceProfile& profile, const DriverTraits& driver,
                       const PlayerOptions& options) {
  SafetyLimits limits;
  limits.peak = {std::min(profile.peak_force, options.max_force), profile.peak_torque};
  limits.continuous_force = profile.continuous_force;
  limits.continuous_torque = profile.continuous_torque;
  limits.thermal_window_s = profile.thermal_window;
  limits.passivity.acceleration = profile.acceleration_max;
  const PortDamping damping = port_damping_of(profile, driver);
  limits.passivity.damping = damping.translational;
  limits.passivity.rotational_damping = damping.rotational;
  return limits;
}

PlayedDevice make_played_device(const ToolDevice& device, const Pose& X_DH,
                                const PlayerOptions& options, std::size_t k) {
  PlayedDevice played;
  if (device.attached != nullptr) {
    played.device = device.attached;
    return played;
  }
  InsideOptions inside;
  inside.X_DH = X_DH;
  inside.virtual_time = options.virtual_time;
  inside.arm = options.arm;
  inside.seed = options.seed + k;
  inside.recorded = device.recorded;
  // Where options are only checked, what is plugged in is not opened.
  const bool is_inside = device.source.driver->make != nullptr;
  const DriverEntry& driver =
      is_inside ? *device.source.driver : driver_entry(DeviceDriver::kSimulated);
  OpenDevice made = driver.make(device.sheet, inside);
  played.owned = std::move(made.device);
  played.facets = made.facets;
  if (options.injection && k == 0) {
    Injection injection = *options.injection;
    injection.period_ns = options.period_ns;
    played.owned = std::make_unique<FaultyDevice>(std::move(played.owned), injection);
  }
  played.device = played.owned.get();
  return played;
}

/// Where the gesture's hand at tool number k is before it moves.
std::optional<Pose> begin_of(const GesturePlan* gesture, std::size_t k) {
  if (gesture == nullptr || k >= gesture->motions.size()) return std::nullopt;
  const GestureTrack track = gesture->motions[k].track();
  if (track.empty()) return std::nullopt;
  const GesturePoint& point = track.legs.empty() ? track.samples.front() : track.legs.front().point;
  return Pose{to_quaternion(point.q_DH), to_vector(point.p_DH)};
}

PlayedTool make_played_tool(const ToolDescription& tool, std::size_t k, const GesturePlan* gesture,
                            const PlayerOptions& options) {
  const ToolDevice& device = device_of(options, tool.tool_id);
  if (device.attached != nullptr && device.tool_id != tool.tool_id) {
    throw std::runtime_error("tool " + std::to_string(tool.tool_id) +
                             " has no device. Name one for it in the configuration.");
  }
  const DeviceProfile& profile = device.sheet.profile;
  PlayedTool played;
  played.tool_id = tool.tool_id;
  played.map = tool.workspace;
  played.X_WG_home = tool.X_WG;
  const Pose home = to_device(played.map, WorkspaceState{}, tool.X_WG);
  played.device = make_played_device(device, begin_of(gesture, k).value_or(home), options, k);
  DriverTraits& traits = played.device.traits;
  traits = driver_entry(played.device.device->profile().driver).traits;
  played.limits = limits_of(profile, traits, options);
  DriverTraits bearing = traits;
  bearing.has_no_clock = driver_entry(profile.driver).traits.has_no_clock;
  played.stiffness_limits =
      stiffness_limits_of(profile, bearing, 1e-9 * static_cast<double>(options.period_ns));
  return played;
}

/// The motion of one tool; throws with the first fault.
GestureMotion plan_motion(const v1::Gesture& gesture, const ToolDescription& tool,
                          const SceneDescription& description) {
  const WorkspaceMap& map = tool.workspace;
  MotionResult result = resolve_gesture(gesture, tool.tool_id, description, [&](const Pose& X_WH) {
    return to_device(map, WorkspaceState{}, X_WH);
  });
  if (any_fault(result.problems)) {
    const auto fault = std::find_if(result.problems.begin(), result.problems.end(),
                                    [](const SceneProblem& problem) { return !problem.doubt; });
    const std::string text = "gesture " + gesture.name() + " does not fit: " + fault->field + ": " +
                             fault->message + ". " + fault->remedy;
    throw std::runtime_error(text);
  }
  return result.motion ? std::move(*result.motion) : GestureMotion{};
}

}  // namespace

const ToolDevice& device_of(const PlayerOptions& options, std::uint32_t tool_id) {
  const auto found =
      std::find_if(options.devices.begin(), options.devices.end(),
                   [&](const ToolDevice& device) { return device.tool_id == tool_id; });
  return found == options.devices.end() ? options.devices.front() : *found;
}

void follow_config(const v1::Config& config, PlayerOptions& options) {
  options.arm = static_cast<ArmKind>(config.arm());
  options.seed = config.seed();
  options.max_force = config.has_max_force() ? config.max_force() : kUnlimited;
  options.budget_us = std::nullopt;
  if (config.has_budget_us()) options.budget_us = config.budget_us();
}

double usual_budget_us(const PlayerOptions& options) {
  return 0.5e-3 * static_cast<double>(options.period_ns);
}

double tick_budget_us(const v1::Quality& quality, const PlayerOptions& options) {
  if (quality.has_automatic()) return quality.automatic().budget_us();
  return options.budget_us.value_or(usual_budget_us(options));
}

std::unique_ptr<GesturePlan> plan_gesture(const v1::Gesture& gesture, const LoadedScene& scene) {
  const SceneDescription& description = scene.scene->description();
  auto plan = std::make_unique<GesturePlan>();
  const std::size_t length = std::min(gesture.name().size(), kGestureNameCapacity);
  std::copy_n(gesture.name().begin(), length, plan->name.begin());
  plan->motions.reserve(description.tools.size());
  for (const ToolDescription& tool : description.tools) {
    plan->motions.push_back(plan_motion(gesture, tool, description));
  }
  return plan;
}

std::unique_ptr<PlayedScene> make_played_scene(std::shared_ptr<const LoadedScene> loaded,
                                               std::uint32_t scene_id,
                                               std::unique_ptr<GesturePlan> gesture,
                                               const PlayerOptions& options) {
  const Scene& scene = *loaded->scene;
  const SceneDescription& description = scene.description();
  if (description.tools.empty() || description.tools.size() > kMaxTools) {
    throw std::runtime_error("scene " + description.name + " has " +
                             std::to_string(description.tools.size()) +
                             " tools: 1 to 5 can be played. Leave the others out.");
  }
  auto played = std::make_unique<PlayedScene>();
  played->scene_id = scene_id;
  const double budget_us = tick_budget_us(loaded->message.quality(), options);
  played->work_budget = first_work(1e3 * budget_us, options.virtual_time);
  played->play = scene.simulate();
  played->settings = scene_settings(description);
  played->strings.resize(played->settings.pieces.size());
  played->tools.reserve(description.tools.size());
  for (std::size_t k = 0; k < description.tools.size(); ++k) {
    played->tools.push_back(make_played_tool(description.tools[k], k, gesture.get(), options));
    played->play.simulation->scene(k).strings = played->strings;
  }
  played->gesture = std::move(gesture);
  apply_settings(*played);
  played->scene = std::shared_ptr<const Scene>(std::move(loaded), &scene);
  return played;
}

}  // namespace hapticd
