// All that a loop keeps from tick to tick, written down and taken back. Filling is RT; restoring is
// not.
#pragma once

#include <array>

#include "core/math/realtime.h"
#include "core/safety/loop_state.h"
#include "core/safety/overrun_watch.h"
#include "server/haptic_loop/settings_ramp.h"
#include "server/haptic_loop/snapshot.h"
#include "server/haptic_loop/tool_loop.h"

namespace hapticd {

/// What a loop keeps beside its scene. Of a tool's part a snapshot has what goes from tick to tick.
struct LoopMemory {
  LoopTime time;
  bool first_tick = true;  ///< of the scene
  LoopMachine machine;
  OverrunWatch overruns;
  SettingsRamp ramp;
  std::array<ToolLoop, kMaxTools> tools;  ///< as many as the scene has
};

/// Between two ticks. False when it is too much for a snapshot. Cost: a copy of each number.
[[nodiscard]] HD_REALTIME bool fill_snapshot(const LoopMemory& loop, const PlayedScene& scene,
                                             Snapshot& snapshot) noexcept;

/// Goes on from `snapshot`, which may come from a file. False when it does not fit the scene; loop
/// and scene are of no use then.
[[nodiscard]] bool restore(const Snapshot& snapshot, PlayedScene& scene, LoopMemory& loop);

}  // namespace hapticd
