// A sphere-tree with what is known of it: what it was made from, and how far its spheres are off
// the solid they stand for. Data alone. Offline.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/tree/sphere_tree.h"

namespace hapticd {

/// BLAKE2b-256.
using ContentHash = std::array<std::uint8_t, 32>;

/// One level of a tree taken for the surface, as QueryOptions::tool_level and body_level do.
struct TreeLevel {
  std::int32_t spheres = 0;  ///< slots of this level and leaves above it
  double outer = 0.0;        ///< no point of its spheres is further outside the solid, m
  double mean = 0.0;         ///< mean distance outside, m
};

/// A tree and where it comes from.
struct MeasuredTree {
  SphereTree tree;
  ContentHash source{};     ///< of the mesh file
  std::string source_name;  ///< file or model it was made from, for people, up to 255 bytes
  /// Bound of the leaves, m; of a blended surface, measured.
  double outer = 0.0;
  /// How far the mesh may stick out of the leaves, m; of a blended surface, measured.
  double inner = 0.0;
  std::vector<TreeLevel> levels;  ///< from the root's children to the leaves, tree.depth entries
};

}  // namespace hapticd
