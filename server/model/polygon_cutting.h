// Cuts a polygon of a mesh file into triangles by its ears (Meisters, "Polygons have ears", Amer.
// Math. Monthly 82, 1975), or says why triangles cannot represent it. A hole may be joined to the
// rim by an edge there and back. Offline.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "server/model/packing/triangle_mesh.h"

namespace hapticd {

/// Most corners of a polygon. Cutting takes about the square of them, in spirals and zigzags too;
/// where ears are rare and far apart it may take the cube.
inline constexpr std::size_t kMaxCorners = 4096;

/// What the triangles may have more area than the polygon, as a share of it. 0 for a plane one; in
/// one that is bent the triangles are one of several surfaces it may mean. Normal value 0.02, a
/// square folded along a diagonal by 22 degrees; larger: the surface is further from what was
/// meant.
inline constexpr double kMaxExcessArea = 0.02;

struct CutPolygon {
  /// Places in the list of corners, turning as the polygon does.
  std::vector<Triangle> triangles;
  /// Empty: the polygon's winding number is 0 or 1 everywhere up to rounding, and as many
  /// triangles cover a place. Edges there and back and corners that touch are not a fault.
  /// Otherwise a clause about it for people, such as "crosses itself"; then there are no triangles.
  std::string fault;
};

/// `corners` (3 or more, finite) in order, m or any other unit: tolerances are those of coordinates
/// rounded to floats. The area of a polygon is half the norm of the sum of p_i x p_(i+1). Corners
/// that repeat the one before are left out; every other edge is one of a triangle. For the cost see
/// kMaxCorners.
[[nodiscard]] CutPolygon cut_polygon(std::span<const Vector3> corners);

}  // namespace hapticd
