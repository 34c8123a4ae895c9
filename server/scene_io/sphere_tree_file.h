// Binary file of a sphere-tree: what hapticd-model writes and scenes load. Little-endian, with
// version, hash of what it was made from, level table and a hash of its own content. Whatever the
// bytes are, a tree that is read is sound: links go down, every leaf is reached once, every bound
// contains the leaves below it. Offline.
//
// Layout (u: unsigned integer of that many bits, f64: IEEE double; nothing is padded):
//   magic "HDTREE\r\n", u32 version, u32 leaves, u32 nodes, u32 levels, u32 bytes of the name
//   32 bytes hash of the source, f64 outer, f64 inner, 4 f64 bound of all (x y z r)
//   per level: u32 spheres, f64 outer, f64 mean; the name
//   per leaf: 4 f64 x y z r
//   per node: u8 used, u8 inner; per used slot, lowest first: of an inner slot 4 f64 x y z r of its
//   bound, of another one u32 leaf
//   in version 2: f64 width of the blend
//   32 bytes BLAKE2b-256 of all before
// Nodes are in breadth-first order, so the n-th inner slot of the file leads to node n (the root is
// node 0): a link that goes up or twice to the same node cannot be written down.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/tree/measured_tree.h"

namespace hapticd {

/// Of all `bytes`. About 1 ns per byte.
[[nodiscard]] ContentHash content_hash(std::span<const std::uint8_t> bytes);

/// Longest MeasuredTree::source_name, bytes.
inline constexpr std::size_t kMaxSourceName = 255;
/// Least width of a blend, m: far above the rounding of distances.
inline constexpr double kMinBlend = 1e-6;
/// Largest coordinate, radius or bound in a file, m: anything a hand moves is far below, and
/// squares stay far from overflow. Larger ones are refused.
inline constexpr double kMaxFileLength = 1e3;

/// The same tree gives the same bytes on every machine. Throws std::invalid_argument when
/// decode_sphere_tree would refuse the result.
[[nodiscard]] std::vector<std::uint8_t> encode_sphere_tree(const MeasuredTree& file);

/// Throws std::runtime_error saying what is wrong (without a file name). Memory and time are
/// bounded by the size of `bytes`; at most kMaxTreeDepth checks per leaf.
[[nodiscard]] MeasuredTree decode_sphere_tree(std::span<const std::uint8_t> bytes);

}  // namespace hapticd
