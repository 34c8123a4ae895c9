// Few spheres that cover the surface of a solid and stick out of it little: the leaves of its
// sphere-tree. Offline. Deterministic: the same mesh and options give the same bits with any number
// of threads and any compiler.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "core/geometry/sphere.h"
#include "server/model/packing/mesh_distance.h"

namespace hapticd {

struct PackingOptions {
  /// Bound: no point of a sphere is further outside the solid, m, > 0. Ignored when `leaves` is
  /// given.
  double outer = 250e-6;
  /// Instead: at most this many spheres, with the smallest bound found, >= 1.
  std::optional<int> leaves;
  /// The surface may stick out of the spheres by this much, m, >= 0. 0: covered all over.
  double inner = 0.0;
  std::uint64_t seed = 1;
  int threads = 1;  ///< >= 1
  /// Called now and then from the calling thread with the share done, in [0, 1]; may be empty.
  std::function<void(double done)> progress;
};

struct Packing {
  std::vector<Sphere> leaves;
  double outer = 0.0;  ///< bound that holds for every point of every sphere, m
  double inner = 0.0;  ///< as asked, m
};

/// Throws std::invalid_argument when an option is out of range, std::runtime_error when the bound
/// would take more spheres than a tree may have.
[[nodiscard]] Packing pack_spheres(const TriangleMesh& mesh, const MeshDistance& distance,
                                   const PackingOptions& options);

}  // namespace hapticd
