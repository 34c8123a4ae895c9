// What shapes are put together from: loops lofted to closed meshes, spheres from triangles of even
// size, welding, moving, joining. Deterministic to the bit (no libm but sqrt). Offline (allocates).
#pragma once

#include <span>
#include <vector>

#include "server/model/packing/triangle_mesh.h"

namespace hapticd {

/// A closed curve as points, the last joined to the first.
using Loop = std::vector<Vector3>;

/// A point of a curve in a plane with its unit normal, which points out of the solid.
struct CurvePoint {
  double u, v;
  double normal_u, normal_v;
};

/// A closed surface through loops of equal size (>= 3 points, >= 2 loops). Seen against the way
/// from the first loop to the last each loop runs counter-clockwise. The ends are closed by rungs
/// between points k and n - 1 - k, so the two halves of an end loop must face each other. Equal
/// points are welded, so a loop may shrink to a point or its corners to one each. Throws
/// std::invalid_argument when the sizes differ.
[[nodiscard]] TriangleMesh loft(std::span<const Loop> loops);

/// Closed surface of revolution about the y axis, `segments` (>= 3) around. `profile` holds (u =
/// distance from the axis, v = y) from the lower end to the upper; first and last on the axis (u =
/// 0 exactly), all others off it. Normals are not used.
[[nodiscard]] TriangleMesh revolve(std::span<const CurvePoint> profile, int segments);

/// A profile (u = x, v = y, counter-clockwise, halves facing each other as for loft()) drawn out
/// along z, centred, `length` over all; the edges at its ends are rounded with `edge` >= 0, which
/// must be below every convex radius of the profile. `segments` >= 1 chords per rounding, `pieces`
/// >= 1 between the roundings.
[[nodiscard]] TriangleMesh extrude(std::span<const CurvePoint> profile, double length, double edge,
                                   int segments, int pieces);

/// Unit sphere: an icosahedron with its edges cut in `frequency` >= 1 parts, 20 frequency^2
/// triangles of about the same size, vertices on the sphere.
[[nodiscard]] TriangleMesh geodesic_sphere(int frequency);

/// Adds the triangles of `part` to `mesh`; nothing is welded.
void append(TriangleMesh& mesh, const TriangleMesh& part);

/// p -> R p + p_offset for all vertices; R a rotation or another map that keeps handedness.
void move(TriangleMesh& mesh, const Matrix3& R, const Vector3& p_offset);

/// Mirror image in the plane x = 0, still oriented outwards.
[[nodiscard]] TriangleMesh mirrored(const TriangleMesh& mesh);

/// A quarter of a circle about (u, v): from the normal (1, 0) to (0, 1), turned by `quarter`
/// quarters counter-clockwise, without rounding.
struct QuarterCircle {
  double u, v;
  double radius;
  int quarter;
};

/// Appends its points, both ends exact, with `segments` >= 1 chords.
void add_quarter(std::vector<CurvePoint>& curve, const QuarterCircle& arc, int segments);

}  // namespace hapticd
