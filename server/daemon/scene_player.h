// Makes what the loop plays out of a loaded scene: simulation, and of each tool map, device and
// limits; and the gesture. Not RT.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "device/attach/drivers.h"
#include "device/faulty/faulty_device.h"
#include "hapticd/v1/config.pb.h"
#include "hapticd/v1/gesture.pb.h"
#include "server/haptic_loop/played_scene.h"
#include "server/scene_io/scene_loader.h"

namespace hapticd {

/// What is behind a tool.
struct ToolDevice {
  std::uint32_t tool_id = 0;
  DeviceSheet sheet;
  DeviceSource source;
  DeviceDriver recorded = DeviceDriver::kReplay;  ///< of a replay: what was there
  HapticDevice* attached = nullptr;               ///< one outside the process; outlives the scenes
};

/// How scenes are played in this run of the daemon.
struct PlayerOptions {
  std::vector<ToolDevice> devices;  ///< at least one; tools not listed have one like the first
  ArmKind arm = ArmKind::kLight;
  std::uint64_t seed = 1;
  std::int64_t period_ns = 1'000'000;
  bool virtual_time = false;
  double max_force = kUnlimited;       ///< N
  std::optional<double> budget_us;     ///< of a tick, [0, 1e6]; 0: no bound; absent: half the tick
  std::optional<Injection> injection;  ///< a fault in front of the first tool's device
};

/// The device of a tool.
[[nodiscard]] const ToolDevice& device_of(const PlayerOptions& options, std::uint32_t tool_id);

/// Takes over the part of the configuration that may differ from scene to scene: arm, seed, largest
/// force, budget.
void follow_config(const v1::Config& config, PlayerOptions& options);

/// Half the tick, us.
[[nodiscard]] double usual_budget_us(const PlayerOptions& options);

/// CPU time that bounds the work of a tick at `quality`, us, [0, 1e6]; 0: no bound. Automatic
/// quality keeps its own.
[[nodiscard]] double tick_budget_us(const v1::Quality& quality, const PlayerOptions& options);

/// Where the hands' gesture leads, of each tool in D. Throws std::runtime_error with the first
/// fault when it does not fit the scene.
[[nodiscard]] std::unique_ptr<GesturePlan> plan_gesture(const v1::Gesture& gesture,
                                                        const LoadedScene& scene);

/// What plays, its first ticks bounded by what they may take of the time, at a price that is not
/// known yet. `gesture` (may be null) is for simulated devices, which begin where it begins.
/// Throws std::runtime_error when the scene has more tools than can be played.
[[nodiscard]] std::unique_ptr<PlayedScene> make_played_scene(
    std::shared_ptr<const LoadedScene> scene, std::uint32_t scene_id,
    std::unique_ptr<GesturePlan> gesture, const PlayerOptions& options);

}  // namespace hapticd
