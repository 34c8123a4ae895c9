// Mesh files: OBJ, STL, PLY, glTF in (through assimp, so coordinates carry the 24 bits of a float),
// PLY and OBJ out. Readers run in a separate process, since damaged files make some of them
// crash or loop. Not RT.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/model/packing/triangle_mesh.h"
#include "server/scene_io/sphere_tree_file.h"

namespace hapticd {

/// Largest file that is read, bytes; larger ones are refused. 512 MiB: some millions of triangles,
/// far more than a tree can make use of.
inline constexpr std::uint64_t kMaxMeshFile = std::uint64_t{512} << 20U;
/// Most triangles of a file.
inline constexpr std::size_t kMaxTriangles = 5'000'000;

struct SourceMesh {
  TriangleMesh mesh;   ///< equal vertices joined, m
  ContentHash hash{};  ///< of the file's bytes (without files it refers to)
};

/// The whole file, at most `largest` bytes. Throws std::runtime_error with the path and the remedy.
[[nodiscard]] std::vector<std::uint8_t> read_bytes(const std::string& path, std::uint64_t largest);

/// Writes to a new file beside `path` and renames it, so that no reader sees half of it; a file
/// that holds these bytes already stays as it is, so that nothing made from it is out of date.
/// Throws std::runtime_error with the path.
void write_bytes(const std::string& path, const std::vector<std::uint8_t>& bytes);

/// Reads a mesh by the ending of its name (.obj .stl .ply .gltf .glb): polygons are cut into
/// triangles (polygon_cutting.h), the nodes of a scene placed, coordinates multiplied by
/// `metres_per_unit`, vertices at exactly one place joined. Points and lines are left out. Whether
/// it is sound is for check_mesh to say. Throws std::runtime_error with the path, the fault and the
/// remedy: also for a polygon that crosses itself or is not plane.
[[nodiscard]] SourceMesh read_mesh(const std::string& path, double metres_per_unit);

/// Writes binary little-endian PLY (coordinates as floats) or OBJ (nine digits) by the ending of
/// the name. Throws std::runtime_error with the path; also for another ending.
void write_mesh(const std::string& path, const TriangleMesh& mesh);

/// Hash of a mesh that comes from no file: of its coordinates as doubles and its indices.
[[nodiscard]] ContentHash mesh_hash(const TriangleMesh& mesh);

}  // namespace hapticd
