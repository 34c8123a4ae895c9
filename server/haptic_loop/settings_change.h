// Live settings of a played scene: put in force, and changed along a ramp. A change is prepared
// outside the loop and lent to it (LoopChannels). RT: yes.
#pragma once

#include <cstdint>
#include <span>

#include "core/scene/scene_settings.h"
#include "server/haptic_loop/played_scene.h"

namespace hapticd {

/// A change of settings. Both hold the settings of the same scene, so as many tools and pieces.
struct SettingsChange {
  std::uint64_t number = 0;   ///< of the command that brought it
  std::uint64_t at_tick = 0;  ///< its ramp begins with this tick, or the next if that has passed
  SceneSettings to;
  SceneSettings from;  ///< room for what was in force when the ramp began
  double time_s = 0.0;  ///< that the ramp takes at least; follows from both (set_time)
};

/// Where a tool and its hand were in the tick before: what a map that moves pulls at.
struct PulledTool {
  Array3 p_DH{};  ///< m
  Pose X_WH;
  Pose X_WG;
};

/// Puts scene.settings in force: stiffness clamped to what the devices bear, constants of strings
/// derived, the maps to the devices set.
HD_REALTIME void apply_settings(PlayedScene& scene) noexcept;

/// True when every number is in the range in which nothing breaks. For settings from a file; others
/// have passed the stricter checks of scenes.
[[nodiscard]] bool usable(const SceneSettings& settings) noexcept;

/// Notes what is in force as the beginning of `change`'s ramp, and how long that takes.
HD_REALTIME void begin_change(const PlayedScene& scene, SettingsChange& change) noexcept;
/// change.time_s of its two ends.
HD_REALTIME void set_time(SettingsChange& change) noexcept;

/// The share of `change` after a tick of `dt_s` that began at `share`. A map that moves takes a tool
/// in touch no further than its coupling is stretched by the step that may be felt, so `tools` has
/// each tool of `scene`.
[[nodiscard]] HD_REALTIME double next_share(const SettingsChange& change, double share, double dt_s,
                                            const PlayedScene& scene,
                                            std::span<const PulledTool> tools) noexcept;

/// Puts in force what is `share` in [0, 1] of the way along `change`.
HD_REALTIME void follow_change(const SettingsChange& change, double share,
                               PlayedScene& scene) noexcept;

}  // namespace hapticd
