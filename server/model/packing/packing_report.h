// How good a packing is, measured: both surfaces sampled densely, distances exact. Offline.
#pragma once

#include <span>

#include "core/geometry/sphere.h"
#include "core/geometry/sphere_tree_view.h"
#include "server/model/packing/mesh_distance.h"

namespace hapticd {

/// Distances of many sample points, m; 0 where there are none.
struct DistanceStatistics {
  double max = 0.0;
  double mean = 0.0;
  double p99 = 0.0;
};

struct PackingReport {
  /// Of points on the surface that lie outside the mesh: their distance to it.
  DistanceStatistics outside;
  /// Of all surface samples of the mesh: how far they stick out of the spheres, 0 where covered.
  DistanceStatistics inside;
  double uncovered = 0.0;  ///< share of the mesh's surface samples outside all spheres
  double scallop = 0.0;   ///< difference of the 99th and the 1st percentile of outside distances, m
  double diagonal = 0.0;  ///< of the mesh's bounding box, m
  std::int64_t mesh_samples = 0;
  std::int64_t sphere_samples = 0;  ///< on the surface of the union
};

struct ReportOptions {
  std::int64_t samples = 200'000;  ///< of each surface, about; >= 1
  std::uint64_t seed = 1;
  int threads = 1;  ///< >= 1
  /// The tree whose leaves the spheres are, where they blend: then its surface is measured
  /// (core/collision/blended_surface.h) in place of the union's. Or nullptr.
  const SphereTreeView* blend = nullptr;
};

/// Samples of the mesh: uniform by area, and every vertex. Samples of the union: uniform by area on
/// the spheres, without those inside another sphere; fewer than asked where almost all of the
/// spheres' surface is hidden. `distance` is that of `mesh`, closed. Deterministic with any number
/// of threads. Throws std::invalid_argument for options out of range or no spheres. About 2 us per
/// sample.
[[nodiscard]] PackingReport report_packing(const TriangleMesh& mesh, const MeshDistance& distance,
                                           std::span<const Sphere> spheres,
                                           const ReportOptions& options);

}  // namespace hapticd
