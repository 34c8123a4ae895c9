// Exact distance from a point to a triangle mesh, signed for closed ones: the truth that
// sphere packings are made with and judged by. A tree of boxes over the triangles; the sign by the
// pseudonormal of the nearest vertex, edge or face (J. A. Baerentzen and H. Aanaes, "Signed
// distance computation using the angle weighted pseudonormal", IEEE TVCG 2005). Offline (allocates
// when made); queries allocate nothing and may run in many threads at once.
#pragma once

#include "core/modeling/triangle_mesh.h"

namespace hapticd {

/// Point of a mesh nearest to another point.
struct NearestPoint {
  double distance = 0.0;  ///< m, >= 0
  Vector3 p{0.0, 0.0, 0.0};
  std::int32_t triangle = 0;
};

class MeshDistance {
 public:
  /// `mesh` is copied; at least one triangle, finite vertices, valid indices (check_mesh). O(n log
  /// n).
  explicit MeshDistance(const TriangleMesh& mesh);

  /// Deterministic; of equally near points that of the lowest triangle.
  [[nodiscard]] NearestPoint nearest(const Vector3& p) const noexcept;

  /// Distance of `p` to the surface, negative inside; the mesh must be closed and consistently
  /// oriented, and not intersect itself.
  [[nodiscard]] double signed_distance(const Vector3& p) const noexcept;
};

}  // namespace hapticd
