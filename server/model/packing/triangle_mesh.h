// A triangle mesh: what shapes are made from, before spheres. Offline. Frame: the shape's own.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/math/vector.h"

namespace hapticd {

/// Indices of three vertices, counter-clockwise seen from outside.
using Triangle = std::array<std::int32_t, 3>;

/// Vertices in m. A solid's mesh is closed: every edge belongs to two triangles, in opposite
/// directions.
struct TriangleMesh {
  std::vector<Vector3> vertices;
  std::vector<Triangle> triangles;
};

/// Corners of a triangle of `mesh`, m. Its indices must be in range.
inline std::array<Vector3, 3> corners(const TriangleMesh& mesh, const Triangle& t) {
  return {mesh.vertices[static_cast<std::size_t>(t[0])],
          mesh.vertices[static_cast<std::size_t>(t[1])],
          mesh.vertices[static_cast<std::size_t>(t[2])]};
}

}  // namespace hapticd
