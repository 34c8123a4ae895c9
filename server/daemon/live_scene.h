// A scene that plays, or is about to, as the daemon and its clients know it: what is set, with the
// changes that the loop has been lent and that are not over yet. Not RT.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>

#include "server/encoding/scene_index.h"
#include "server/haptic_loop/settings_change.h"
#include "server/scene_io/scene_loader.h"

namespace hapticd {

struct LiveScene {
  std::uint32_t id = 0;
  std::shared_ptr<const LoadedScene> loaded;
  SceneIndex index;
  v1::SceneInfo info;  ///< as of now; no longer for what is set live, but for a few knobs
  /// With the parameters as they are set now, ramps as if ended; knobs that quality decides are
  /// left open.
  v1::Scene live;
  v1::Quality choice;      ///< of the scene, or of clients since; --quality may stand above it
  SceneSettings settings;  ///< that follow from `live`, at the level that plays

  struct Parameters {
    v1::Scene live;
    v1::Quality choice;
    SceneSettings settings;
  };
  /// A change that the loop has been lent.
  struct Change {
    std::uint64_t number = 0;   ///< of its command
    std::uint64_t at_tick = 0;  ///< it begins then, or soon after
    Parameters parameters;      ///< after it
  };
  std::deque<Change> changes;  ///< not over yet, as they were asked for
  Parameters in_force;         ///< after the last one that is over

  /// They are what is set now, and told.
  void take(Parameters now);
  /// What is in force at a tick that is near.
  [[nodiscard]] const v1::Quality& quality_at(std::uint64_t tick) const;
  /// The change of this number is over, or was `dropped` before it began, and what it set is unset.
  /// False: it is of another scene.
  bool settle(std::uint64_t number, bool dropped);
};

}  // namespace hapticd
