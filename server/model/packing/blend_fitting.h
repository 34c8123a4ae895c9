// Radii of balls that cover a solid, fitted so that their blended surface
// (core/collision/blended_surface.h) lies on the mesh: smooth where the union of the balls is
// scalloped, and nearer. Offline. Deterministic, with any number of threads.
#pragma once

#include <vector>

#include "core/geometry/sphere.h"
#include "server/model/packing/mesh_distance.h"

namespace hapticd {

struct BlendOptions {
  double width = 1e-3;    ///< of the blend, m, > 0
  double bound = 250e-6;  ///< that the balls were packed with, m: the surface is sampled by it
  int threads = 1;        ///< >= 1
};

/// How far the blended surface is off the mesh, at the corners and in the middle of patches that
/// the mesh is divided into.
struct BlendFit {
  double outer = 0.0;  ///< largest distance outside, m
  double mean = 0.0;   ///< mean of it, m
  double inner = 0.0;  ///< how far the mesh sticks out of it at most, m
};

/// Changes the radii of `leaves` alone. First the smoothest surface a little outside the mesh, felt
/// by tips as large as a finger's, by least squares; then leaves grow where the mesh still sticks
/// out. About 2 ms per leaf.
[[nodiscard]] BlendFit fit_blend(const TriangleMesh& mesh, const MeshDistance& distance,
                                 const BlendOptions& options, std::vector<Sphere>& leaves);

}  // namespace hapticd
