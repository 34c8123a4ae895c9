// What is to be said about a sphere-tree: how far it errs from its mesh, level by level, measured
// afresh. Not RT.
#pragma once

#include <string>
#include <vector>

#include "server/model/packing/mesh_distance.h"
#include "server/model/packing/packing_report.h"
#include "server/scene_io/sphere_tree_file.h"

namespace hapticd {

/// The spheres that represent the surface when a query stops at `level` (1 = the root's children,
/// tree.depth = the leaves): the bounds of that level and the leaves above it.
[[nodiscard]] std::vector<Sphere> level_spheres(const SphereTree& tree, int level);

/// Furthest that a point of one of `spheres` can be outside the solid, m, from above: the distance
/// of the centre (negative inside) plus the radius.
[[nodiscard]] double outer_bound(const MeshDistance& distance, std::span<const Sphere> spheres);

/// The level table of `tree`: bounds by outer_bound, that of the leaves by `leaf_outer`, means by
/// report_packing with `options`.
[[nodiscard]] std::vector<TreeLevel> measure_levels(const TriangleMesh& mesh,
                                                    const MeshDistance& distance,
                                                    const SphereTree& tree, double leaf_outer,
                                                    const ReportOptions& options);

/// All of it.
struct TreeReport {
  std::string name;  ///< of the tree
  const MeasuredTree* file = nullptr;
  PackingReport packing;      ///< of the leaves
  bool has_packing = false;   ///< false when there was no mesh to compare with
  std::size_t triangles = 0;  ///< of the mesh; 0: unknown
  std::size_t bytes = 0;      ///< of the file
  double seconds = -1.0;      ///< the build took; < 0: unknown
  int threads = 0;            ///< the build used
  /// Time in which one thread measures as many points as packing.sphere_samples against every
  /// triangle, s: what `seconds` is compared with. < 0: unknown.
  double exhaustive_seconds = -1.0;
  int levels = kMaxTreeDepth;  ///< rows of the level table, at most, from the coarsest
};

/// TreeReport::exhaustive_seconds, from a few of the points.
[[nodiscard]] double time_exhaustive(const TriangleMesh& mesh, const MeshDistance& distance,
                                     std::int64_t samples);

/// Bytes the loop keeps in memory for `tree`.
[[nodiscard]] std::size_t memory_of(const SphereTree& tree);

/// For people: two tables.
[[nodiscard]] std::string to_markdown(const TreeReport& report);

/// For programs: one JSON object in one line, lengths in m.
[[nodiscard]] std::string to_json(const TreeReport& report);

}  // namespace hapticd
