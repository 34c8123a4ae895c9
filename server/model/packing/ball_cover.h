// A first covering of a surface by balls inside a solid, grown by a bound: greedy set cover over
// the centroids of patches. Offline.
#pragma once

#include <vector>

#include "core/geometry/sphere.h"
#include "server/model/packing/surface_patches.h"

namespace hapticd {

/// Centres of balls (radius: the depth of the centre in the solid, negative outside, m) which,
/// grown by `bound`, contain the centroid of every patch. Candidates are large inner balls at
/// patches drawn by the area a ball covers; the one that adds most area is taken next.
/// Deterministic with any number of threads. About 100 us per ball of the result.
[[nodiscard]] std::vector<Sphere> cover_greedily(const SurfacePatches& surface,
                                                 const MeshDistance& distance, double bound,
                                                 double extent, int threads);

}  // namespace hapticd
