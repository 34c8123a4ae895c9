// Which tool of a scene a request means. Not RT.
#pragma once

#include <algorithm>
#include <cstdint>

#include "server/encoding/scene_index.h"

namespace hapticd {

inline constexpr const char* kNoSuchTool = "The scene has no such tool.";

/// No tool.
inline constexpr std::uint32_t kNoTool = ~0U;

/// Its place in the scene's order; kNoTool when the scene has none of that id.
[[nodiscard]] inline std::uint32_t tool_of(std::uint32_t tool_id, const SceneIndex& index) {
  const auto found = std::find(index.tool_ids.begin(), index.tool_ids.end(), tool_id);
  if (found == index.tool_ids.end()) return kNoTool;
  return static_cast<std::uint32_t>(found - index.tool_ids.begin());
}

}  // namespace hapticd
