// Triangles of a mesh that pass through each other. Offline.
#pragma once

#include <cstdint>

#include "server/model/packing/triangle_mesh.h"

namespace hapticd {

struct MeshCrossings {
  std::int64_t count = 0;      ///< triangles that another one passes through
  std::int32_t triangle = -1;  ///< the first of them
  Vector3 p{0.0, 0.0, 0.0};    ///< a point near the first crossing, m
};

/// Pairs without a common vertex one of whose sides goes through the inside of the other; touching
/// and lying in one plane do not count. Finite vertices, valid indices. Sweeps along the longest
/// side of the bounding box.
[[nodiscard]] MeshCrossings find_crossings(const TriangleMesh& mesh);

}  // namespace hapticd
