// See scene_settings.h.
#include "core/scene/scene_settings.h"

#include "core/scene/sagging_cable.h"

namespace hapticd {

SceneSettings scene_settings(const SceneDescription& description, std::size_t tool) {
  const ToolDescription& described = description.tools[tool];
  SceneSettings settings;
  settings.live = {
      described.coupling,        described.coupling_damping, described.force_gain,
      described.workspace.scale, described.workspace.X_WD,   description.optimiser,
      description.instrument,    description.quality_level,  description.quality_automatic};
  for (const StringDescription& string : description.strings) {
    for (const StringParameters& piece : cable_of(string)) settings.pieces.push_back(piece);
  }
  return settings;
}

}  // namespace hapticd
