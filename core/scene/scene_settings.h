// The live settings of a described scene: what a played scene starts from and changes to. Offline.
#pragma once

#include <vector>

#include "core/scene/scene_description.h"
#include "core/simulation/live_settings.h"

namespace hapticd {

/// Settings of every tool, and of every piece of string in the order of the scene's capsules.
struct SceneSettings {
  std::vector<LiveSettings> tools;  ///< what is of the whole scene is the same in all
  std::vector<StringParameters> pieces;
};

/// Settings as `description` has them.
[[nodiscard]] SceneSettings scene_settings(const SceneDescription& description);

}  // namespace hapticd
