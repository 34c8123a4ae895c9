// What is fuzzed of meshes: any bytes as a PLY, STL or OBJ file. Not RT.
#pragma once

#include <cstdint>
#include <span>

namespace hapticd::test {

/// Reads `bytes` but the first as a mesh file: STL where the first is 's' or 'S', PLY where it is
/// 'p' or 'P', else OBJ; a capital says that its unit is the millimetre. What is read names no
/// vertex that is not there; what is found to have an inside, as it is or after a repair, is
/// finite, and each of its edges belongs to two triangles, once each way. What is refused names its
/// file and a remedy in plain text. Throws std::logic_error where that does not hold. True when it
/// has an inside.
bool check_mesh_bytes(std::span<const std::uint8_t> bytes);

}  // namespace hapticd::test
