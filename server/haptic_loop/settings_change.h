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
  // Follow from both (measure).
  double time_s = 0.0;    ///< that the ramp takes at least
  double edged = 0.0;     ///< WayLength::edged of all
  bool straight = false;  ///< there are straight strings
  bool rubs = false;      ///< strings hold what slides on them
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
/// Writes what follows from the two ends of `change`.
HD_REALTIME void measure(SettingsChange& change) noexcept;

/// The share of `change` after a tick of `dt_s` that began at `share`, each tool of `scene` being
/// as `tools` says. A map that moves stretches the coupling of a tool in touch by no more than may
/// be felt; what has an edge, as a scale may have and all has where strings hold by friction,
/// begins and ends so slowly that the part beyond the edge may be small.
[[nodiscard]] HD_REALTIME double next_share(const SettingsChange& change, double share, double dt_s,
                                            const PlayedScene& scene,
                                            std::span<const PulledTool> tools) noexcept;

/// Puts in force what is `share` in [0, 1] of the way along `change`.
HD_REALTIME void follow_change(const SettingsChange& change, double share,
                               PlayedScene& scene) noexcept;

}  // namespace hapticd
