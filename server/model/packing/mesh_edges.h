// Edges of a triangle mesh with the triangles at them, and its connected pieces. Offline.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "server/model/packing/triangle_mesh.h"

namespace hapticd {

/// One side of one triangle.
struct MeshEdge {
  std::int32_t low, high;  ///< vertices, low < high
  std::int32_t triangle;
  bool forward;  ///< the triangle runs from low to high
};

/// All sides of all triangles but those of no length, those of one edge together, by triangle.
/// Indices valid. O(n log n).
[[nodiscard]] std::vector<MeshEdge> mesh_edges(const TriangleMesh& mesh);

/// Calls `visit` once per edge with all its sides.
void for_each_edge(std::span<const MeshEdge> edges,
                   const std::function<void(std::span<const MeshEdge>)>& visit);

/// Number of the connected piece of every triangle, from 0 in the order of first triangles; pieces
/// hang together by vertices. Indices valid.
[[nodiscard]] std::vector<std::int32_t> mesh_pieces(const TriangleMesh& mesh);

/// Six times the signed volume of the cone of triangle `t` with the origin, m^3.
[[nodiscard]] double cone_volume_times_six(const TriangleMesh& mesh, const Triangle& t);

}  // namespace hapticd
