// The zero level of a function as a closed triangle mesh: marching tetrahedra on a body-centred
// cubic lattice whose points are moved onto the surface where it passes close by, so that no
// slivers arise (F. Labelle and J. Shewchuk, "Isosurface stuffing", SIGGRAPH 2007), then a few
// rounds of evening out with the vertices drawn back to the level. Deterministic to the bit.
// Offline.
#pragma once

#include <functional>

#include "server/model/packing/triangle_mesh.h"

namespace hapticd {

/// Negative inside; continuous, and near its zero level about a distance in m.
using ImplicitFunction = std::function<double(const Vector3& p)>;

struct ImplicitMeshOptions {
  /// Box that holds the solid with at least one `cell` of room on all sides, m.
  Vector3 low{0.0, 0.0, 0.0};
  Vector3 high{0.0, 0.0, 0.0};
  /// Side of a lattice cube, m, > 0. Triangles get about this size; details thinner than two cells
  /// may be lost or torn.
  double cell = 0.0;
  /// Rounds of evening out, >= 0. More give triangles of more equal size.
  int rounds = 4;
};

/// Closed, oriented outwards, vertices within 1e-9 m of the level where the function is smooth.
/// Throws std::invalid_argument when the options make no lattice (or one of more than 2^24 cubes),
/// or the solid reaches the box. O(cells) evaluations.
[[nodiscard]] TriangleMesh mesh_implicit(const ImplicitFunction& function,
                                         const ImplicitMeshOptions& options);

}  // namespace hapticd
