// Small closed meshes for tests of modelling, and exhaustive truths about them in long double. Not
// RT.
#pragma once

#include <functional>

#include "server/model/packing/triangle_mesh.h"

namespace hapticd::test {

/// Box with corners at +-half, 12 triangles.
TriangleMesh box_mesh(const Vector3& half);

/// Faces of a cube divided into n x n squares, every vertex moved from the unit sphere's point u to
/// `place(u)`: 12 n^2 triangles, closed and outward for star-shaped places.
TriangleMesh cube_sphere(int n, const std::function<Vector3(const Vector3&)>& place);

/// Ellipsoid with the given half axes.
TriangleMesh ellipsoid_mesh(int n, const Vector3& half);

/// A smooth potato with bumps and hollows, radius between 0.7 and 1.4.
TriangleMesh blob_mesh(int n);

/// Distance from `p` to the nearest of all triangles, by exhaustive search.
long double exhaustive_distance(const TriangleMesh& mesh, const Vector3& p);

/// Number of turns the mesh makes around `p`: 1 inside, 0 outside (sum of solid angles over 4 pi).
long double winding_number(const TriangleMesh& mesh, const Vector3& p);

}  // namespace hapticd::test
