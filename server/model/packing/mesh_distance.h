// Exact distance from a point to a triangle mesh, signed for closed ones: the truth that
// sphere packings are made with and judged by. A tree of boxes over the triangles; the sign by the
// pseudonormal of the nearest vertex, edge or face (J. A. Baerentzen and H. Aanaes, "Signed
// distance computation using the angle weighted pseudonormal", IEEE TVCG 2005). Offline (allocates
// when made); queries allocate nothing and may run in many threads at once.
#pragma once

#include <limits>

#include "server/model/packing/triangle_mesh.h"

namespace hapticd {

/// Point of a mesh nearest to another point.
struct NearestPoint {
  double distance = 0.0;  ///< m, >= 0
  Vector3 p{0.0, 0.0, 0.0};
  std::int32_t triangle = 0;
};

class MeshDistance {
 public:
  /// `mesh` is copied; at least one triangle, finite vertices up to 1e70 m, valid indices
  /// (check_mesh); std::invalid_argument otherwise. O(n log n).
  explicit MeshDistance(const TriangleMesh& mesh);

  /// Deterministic; of equally near points that of the lowest triangle. Error of the distance: a
  /// few roundings of the largest coordinate. O(log n), about 1 us near the surface of 10^4
  /// triangles.
  [[nodiscard]] NearestPoint nearest(const Vector3& p) const noexcept;

  /// The same by looking at every triangle: what the time of anything faster is measured by.
  [[nodiscard]] NearestPoint nearest_by_exhaustion(const Vector3& p) const noexcept;

  /// Distance of `p` to the surface, negative inside; the mesh must be closed and consistently
  /// oriented, and not intersect itself.
  [[nodiscard]] double signed_distance(const Vector3& p) const noexcept;

  /// As signed_distance, with the nearest point: `nearest.distance` stays >= 0.
  [[nodiscard]] double signed_distance(const Vector3& p, NearestPoint& nearest) const noexcept;

  /// Whether the surface comes nearer to `p` than `r`; `found` is then such a point of it, not the
  /// nearest. Several times faster than `nearest`.
  [[nodiscard]] bool find_nearer(const Vector3& p, double r, NearestPoint& found) const noexcept;

 private:
  /// Where on its triangle the nearest point lies.
  enum class Feature : std::uint8_t { kFace, kEdge0, kEdge1, kEdge2, kVertex0, kVertex1, kVertex2 };
  struct Corner3 {
    Vector3 a, b, c;
    std::int32_t id;
  };
  /// Box of `count` triangles from `first` (a leaf), or of the nodes `first` and `first` + 1 when
  /// `count` is 0.
  struct Node {
    Vector3 low, high;
    std::int32_t first;
    std::int32_t count;
  };
  struct Hit {
    double squared = std::numeric_limits<double>::infinity();
    Vector3 p{0.0, 0.0, 0.0};
    std::int32_t id = 0;
    Feature feature = Feature::kFace;
  };

  static Hit nearest_on(const Corner3& triangle, const Vector3& p) noexcept;
  static Hit nearest_on_sides(const Corner3& triangle, const Vector3& p) noexcept;
  [[nodiscard]] Hit search(const Vector3& p) const noexcept;
  void build_tree(const TriangleMesh& mesh);
  void build_normals(const TriangleMesh& mesh);

  std::vector<Corner3> triangles_;  ///< in the order of the tree
  std::vector<Node> nodes_;
  /// By triangle id: normals of its face, edges (ab, bc, ca) and vertices, in the order of Feature.
  std::vector<std::array<Vector3, 7>> normals_;
};

}  // namespace hapticd
