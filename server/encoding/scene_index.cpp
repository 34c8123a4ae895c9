// See scene_index.h.
#include "server/encoding/scene_index.h"

namespace hapticd {

SceneIndex index_scene(const Scene& scene) {
  SceneIndex index;
  const auto owners = scene.capsule_owners();
  const SceneDescription& description = scene.description();
  const auto same = [&](std::size_t a, std::size_t b) {
    return owners[a].index == owners[b].index && owners[a].is_string == owners[b].is_string;
  };
  index.pieces.reserve(owners.size());
  for (std::size_t first = 0; first < owners.size();) {
    std::size_t end = first + 1;
    while (end < owners.size() && same(first, end)) ++end;
    const double share = 1.0 / static_cast<double>(end - first);
    const auto owner = static_cast<std::size_t>(owners[first].index);
    const bool is_string = owners[first].is_string;
    const double radius =
        is_string ? description.strings[owner].parameters.radius : description.lines[owner].radius;
    for (std::size_t k = first; k < end; ++k) {
      index.pieces.push_back({static_cast<std::uint32_t>(owner), is_string, radius,
                              static_cast<double>(k - first) * share, share});
    }
    first = end;
  }
  index.tool_ids.reserve(description.tools.size());
  for (const ToolDescription& tool : description.tools) index.tool_ids.push_back(tool.tool_id);
  return index;
}

double whole_lambda(const PieceOwner& piece, double lambda) noexcept {
  return piece.lambda_begin + piece.lambda_share * lambda;
}

}  // namespace hapticd
