// Constants shared by the writer and the reader of sphere-tree files. See sphere_tree_file.h.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace hapticd {

/// The line break is damaged by programs that take the file for text.
inline constexpr std::array<std::uint8_t, 8> kTreeFileMagic{'H', 'D', 'T',  'R',
                                                            'E', 'E', '\r', '\n'};
/// Raised with every change of the layout; other versions are refused.
inline constexpr std::uint32_t kTreeFileVersion = 1;
/// Bytes of one leaf: four doubles.
inline constexpr std::size_t kTreeFileLeafBytes = 32;
/// Bytes of one entry of the level table.
inline constexpr std::size_t kTreeFileLevelBytes = 20;
/// Fewest bytes of a node: its masks and one slot with a leaf.
inline constexpr std::size_t kTreeFileLeastNodeBytes = 6;

}  // namespace hapticd
