// Binary file of a sphere-tree: what hapticd-model writes and scenes load. Little-endian, with
// version, hash of what it was made from, level table and a hash of its own content. Whatever the
// bytes are, a tree that is read is sound: links go down, every leaf is reached once, every bound
// contains the leaves below it. Offline.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/modeling/sphere_tree.h"

namespace hapticd {

/// BLAKE2b-256.
using ContentHash = std::array<std::uint8_t, 32>;

[[nodiscard]] ContentHash content_hash(std::span<const std::uint8_t> bytes);

/// One level of a tree taken for the surface, as QueryOptions::tool_level and body_level do.
struct TreeLevel {
  std::int32_t spheres = 0;
  double outer = 0.0;  ///< no point of its spheres is further outside the solid, m
  double mean = 0.0;   ///< mean distance outside, m
};

/// A tree and where it comes from.
struct SphereTreeFile {
  SphereTree tree;
  ContentHash source{};           ///< of the mesh file
  std::string source_name;        ///< file or model it was made from, for people, up to 255 bytes
  double outer = 0.0;             ///< bound of the leaves, m
  double inner = 0.0;             ///< how far the surface may stick out of the leaves, m
  std::vector<TreeLevel> levels;  ///< from the root's children to the leaves, tree.depth entries
};

[[nodiscard]] std::vector<std::uint8_t> encode_sphere_tree(const SphereTreeFile& file);

/// Throws std::runtime_error saying what is wrong (without a file name). Memory and time are
/// bounded by the size of `bytes`.
[[nodiscard]] SphereTreeFile decode_sphere_tree(std::span<const std::uint8_t> bytes);

}  // namespace hapticd
