// A mesh's surface in small pieces, for covering it with balls: a piece lies in a ball exactly when
// its three corners do. Small where only small balls fit. Offline.
#pragma once

#include <cstdint>
#include <vector>

#include "server/model/packing/mesh_distance.h"

namespace hapticd {

/// A piece of a triangle of the mesh.
struct Patch {
  Vector3 a, b, c;
  Vector3 normal;      ///< outward, unit
  double area = 0.0;   ///< m^2
  double reach = 0.0;  ///< radius of the disc of surface that one ball covers here, about, m
};

/// Node of a tree over patches: all of `first` ... `first` + `count` - 1; below it the nodes
/// `child` and `child` + 1, or none when `child` is 0.
struct PatchNode {
  Vector3 low, high;  ///< box of the corners
  std::int32_t first = 0;
  std::int32_t count = 0;
  std::int32_t child = 0;
};

struct SurfacePatches {
  std::vector<Patch> patches;        ///< in the order of the tree
  std::vector<PatchNode> nodes;      ///< root first, children after parents
  std::vector<std::int32_t> leaves;  ///< nodes without children, in the order of patches
};

/// How to divide.
struct PatchOptions {
  double bound = 0.0;  ///< how far balls may stick out, m, > 0
  double size = 0.25;  ///< longest side as a share of the reach of a ball
  int threads = 1;
};

/// Balls that `bound` takes, about, from samples of the surface; before dividing it.
[[nodiscard]] double estimated_balls(const TriangleMesh& mesh, const MeshDistance& distance,
                                     double bound);

/// Triangles without area are left out: they lie on the sides of others. Throws std::runtime_error
/// when the number of patches would be beyond kMaxPatches.
[[nodiscard]] SurfacePatches divide_surface(const TriangleMesh& mesh, const MeshDistance& distance,
                                            const PatchOptions& options);

/// Most patches made. Normal value 2^26 (10 GB); more would take the memory of a machine.
inline constexpr std::int64_t kMaxPatches = std::int64_t{1} << 26U;

/// Largest side of the box of the vertices, m.
[[nodiscard]] double mesh_extent(const TriangleMesh& mesh);

}  // namespace hapticd
