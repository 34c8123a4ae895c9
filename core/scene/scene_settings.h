// The live settings of a described scene: what a played scene starts from and changes to. Offline.
#pragma once

#include <vector>

#include "core/scene/scene_description.h"
#include "core/simulation/live_settings.h"

namespace hapticd {

/// Settings of one tool, and of every piece of string in the order of the scene's capsules.
struct SceneSettings {
  LiveSettings live;
  std::vector<StringParameters> pieces;
};

/// Settings of tool number `tool` of `description`.
[[nodiscard]] SceneSettings scene_settings(const SceneDescription& description, std::size_t tool);

}  // namespace hapticd
