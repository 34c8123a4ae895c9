// What this run of the daemon is to do: its options, and how they have scenes played. A SIGHUP
// changes the parts that may change while a scene plays. Not RT.
#pragma once

#include <cstdint>
#include <optional>

#include "hapticd/v1/recording.pb.h"
#include "server/daemon/daemon_options.h"
#include "server/daemon/scene_player.h"
#include "server/scene_io/scene_loader.h"

namespace hapticd {

struct DaemonPlan {
  DaemonOptions options;
  PlayerOptions player;
  std::optional<std::uint16_t> stop_port;  ///< of the Stop road, once there is one
};

/// How `config` has scenes played, by devices that are not attached yet. Throws StartError.
[[nodiscard]] PlayerOptions player_options(const v1::Config& config);

/// How scenes were played when `header` was recorded. Throws StartError.
[[nodiscard]] PlayerOptions recorded_player(const v1::RecordHeader& header);

/// Whether any tool's hand is a simulated one.
[[nodiscard]] bool simulates(const PlayerOptions& player);

/// How to load scenes that are to be played that way.
[[nodiscard]] LoadOptions load_options(const DaemonPlan& plan);

/// Says in the log that the work of a tick has no bound, if so.
void warn_of_no_bound(const PlayerOptions& player);

/// What reading the configuration anew came to.
struct Reread {
  bool good = false;               ///< else nothing has changed, and the log says why
  bool recording_differs = false;  ///< another file, or none, is to be recorded to
};

/// Reads the configuration anew: what a client could change in flight is changed in `plan`; what
/// belongs to the start stays, and the log names it.
Reread reread(DaemonPlan& plan);

}  // namespace hapticd
