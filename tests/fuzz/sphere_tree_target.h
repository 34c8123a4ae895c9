// Fuzz target: the reader of sphere-tree files.
#pragma once

#include <cstdint>
#include <span>

namespace hapticd::test {

/// Reads `bytes` as they are, and with the hash at their end made right, so that the structure
/// behind it is looked at too. Throws std::logic_error when a tree is read that is not sound or
/// does not give the same bytes again. Returns whether one was read.
bool check_sphere_tree_bytes(std::span<const std::uint8_t> bytes);

}  // namespace hapticd::test
