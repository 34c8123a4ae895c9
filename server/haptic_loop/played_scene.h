// A scene as the loop plays it: simulation, and for each tool the map to its device, limits, and
// the device itself where it is inside the process. Built outside the loop, swapped in at a tick
// edge, freed outside. RT: plain access for the loop.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/safety/output_stage.h"
#include "core/safety/stiffness_clamp.h"
#include "core/scene/scene.h"
#include "core/scene/scene_settings.h"
#include "core/simulation/workspace_map.h"
#include "device/api/device_facets.h"
#include "device/api/haptic_device.h"
#include "server/haptic_loop/gesture_plan.h"

namespace hapticd {

/// The device of a tool.
struct PlayedDevice {
  HapticDevice* device = nullptr;
  DeviceFacets facets;
  DriverTraits traits;                  ///< of its driver
  std::unique_ptr<HapticDevice> owned;  ///< null for a device that outlives scenes
};

/// One tool that plays.
struct PlayedTool {
  std::uint32_t tool_id = 0;
  WorkspaceMap map;
  Pose X_WG_home;  ///< where recentring brings the tool
  double force_gain = 1.0;
  SafetyLimits limits;
  StiffnessLimits stiffness_limits;  ///< of the device; coupling_damping is that of the settings
  StiffnessGrant grant;              ///< follows from them and the settings
  /// grant.scale is no larger: while settings move it goes evenly from that of the old ones to that
  /// of the new ones, not by the edge where the device's bound is met.
  double most_scale = 1.0;
  PlayedDevice device;
};

/// What plays.
struct PlayedScene {
  std::uint32_t scene_id = 1;
  std::shared_ptr<const Scene> scene;  ///< what `play` views
  OwnedSimulation play;
  std::vector<StringConstants> strings;  ///< that `play` is played with
  std::vector<PlayedTool> tools;         ///< 1 to kMaxTools, in the scene's order
  SceneSettings settings;                ///< in force (apply_settings)
  std::uint32_t quality_level = 0;
  std::int64_t work_budget = 0;          ///< of its ticks until another is told; 0: no bound
  std::unique_ptr<GesturePlan> gesture;  ///< played from the first tick; may be null
};

}  // namespace hapticd
