// A triangle mesh: what shapes are made from, before spheres. Offline. Frame: the shape's own.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/closest_point.h"

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

/// Dot product, summed in a fixed order.
[[nodiscard]] inline double dot(const Vector3& a, const Vector3& b) noexcept {
  return (a.x() * b.x() + a.y() * b.y()) + a.z() * b.z();
}

/// `v` over its length; zero where it has none.
[[nodiscard]] inline Vector3 unit_or_zero(const Vector3& v) noexcept {
  const double size = length(v);
  return size > 0.0 ? Vector3(v / size) : Vector3(0.0, 0.0, 0.0);
}

}  // namespace hapticd
