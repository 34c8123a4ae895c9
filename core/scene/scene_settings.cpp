// See scene_settings.h.
#include "core/scene/scene_settings.h"

#include "core/scene/sagging_cable.h"

namespace hapticd {

SceneSettings scene_settings(const SceneDescription& description) {
  SceneSettings settings;
  settings.tools.reserve(description.tools.size());
  for (const ToolDescription& tool : description.tools) {
    settings.tools.push_back({tool.coupling, tool.coupling_damping, tool.force_gain,
                              tool.workspace.scale, tool.workspace.X_WD, description.contact,
                              description.instrument, description.quality_level,
                              description.quality_automatic});
  }
  for (const StringDescription& string : description.strings) {
    for (const StringParameters& piece : cable_of(string)) settings.pieces.push_back(piece);
  }
  return settings;
}

}  // namespace hapticd
