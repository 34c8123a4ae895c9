// Which tool of a scene a request means. Not RT.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "proto/wire/request_result.h"
#include "server/encoding/scene_index.h"

namespace hapticd {

/// No tool.
inline constexpr std::uint32_t kNoTool = ~0U;

/// Its place in the scene's order; kNoTool when the scene has none of that id.
[[nodiscard]] inline std::uint32_t tool_of(std::uint32_t tool_id, const SceneIndex& index) {
  const auto found = std::find(index.tool_ids.begin(), index.tool_ids.end(), tool_id);
  if (found == index.tool_ids.end()) return kNoTool;
  return static_cast<std::uint32_t>(found - index.tool_ids.begin());
}

/// The answer to a request whose field `path` names such a tool.
[[nodiscard]] inline v1::Result no_such_tool(const std::string& path) {
  return wire::result_of(v1::RESULT_CODE_NOT_FOUND, path, "The scene has no such tool.");
}

}  // namespace hapticd
