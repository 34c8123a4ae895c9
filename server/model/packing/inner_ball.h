// Large balls inside a solid: shrinking ball (J. Ma, S. W. Bae, S. Choi, "3D medial axis point
// approximation using nearest neighbors and the normal field", The Visual Computer 2012) with exact
// distances, and slack so that the shallow edges of a divided smooth surface do not make it small.
// Offline.
#pragma once

#include "core/geometry/sphere.h"
#include "server/model/packing/mesh_distance.h"

namespace hapticd {

/// About the largest ball that touches the surface at `p` from inside (`normal` outward, unit) and
/// sticks out of the solid nowhere more than `slack` (> 0, m); `largest` bounds its radius, m. The
/// radius of the result is the distance from `p`. `refine` more halvings make it larger. About 10
/// us.
[[nodiscard]] Sphere inner_ball(const MeshDistance& distance, const Vector3& p,
                                const Vector3& normal, double slack, double largest, int refine);

}  // namespace hapticd
