// Measures of a triangle mesh by counting and summing in long double: whether it is a closed
// surface, of how many pieces, how large. For tests; not RT.
#pragma once

#include <cstdint>

#include "server/model/packing/triangle_mesh.h"

namespace hapticd::test {

struct MeshMeasures {
  /// Every edge is used once in each direction, all indices are valid, all vertices are used.
  bool closed = false;
  std::int64_t pieces = 0;
  std::int64_t euler = 0;       ///< vertices - edges + triangles: 2 per piece without handles
  long double volume = 0.0L;    ///< m^3, positive when triangles face outwards
  long double area = 0.0L;      ///< m^2
  long double flattest = 0.0L;  ///< least height of a triangle over its longest side
  Vector3 low{0.0, 0.0, 0.0};   ///< bounding box, m
  Vector3 high{0.0, 0.0, 0.0};
};

MeshMeasures measure(const TriangleMesh& mesh);

/// A point of a triangle: corner 0 plus u and v parts of the way to the others.
Vector3 point_of(const TriangleMesh& mesh, const Triangle& triangle, double u, double v);

}  // namespace hapticd::test
