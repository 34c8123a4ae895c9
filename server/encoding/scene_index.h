// From the numbers the loop uses (capsules, tools by index) to those of the wire (strings and lines
// of the scene, tool ids). Made once per scene. Not RT.
#pragma once

#include <cstdint>
#include <vector>

#include "core/scene/scene.h"

namespace hapticd {

/// What a capsule of the scene is a piece of, and where along it.
struct PieceOwner {
  std::uint32_t index = 0;  ///< in Scene.strings or Scene.lines
  bool is_string = false;
  double radius = 0.0;        ///< m
  double lambda_begin = 0.0;  ///< of the piece along the whole, by number of pieces
  double lambda_share = 1.0;
};

/// The scene as the wire numbers it.
struct SceneIndex {
  std::vector<PieceOwner> pieces;       ///< by capsule
  std::vector<std::uint32_t> tool_ids;  ///< by tool
};

/// The index of `scene`.
[[nodiscard]] SceneIndex index_scene(const Scene& scene);

/// Place along the whole string or line of `lambda` along its piece.
[[nodiscard]] double whole_lambda(const PieceOwner& piece, double lambda) noexcept;

}  // namespace hapticd
