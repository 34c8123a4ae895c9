// Large balls inside a solid: shrinking ball (J. Ma, S. W. Bae, S. Choi, "3D medial axis point
// approximation using nearest neighbors and the normal field", The Visual Computer 2012) with exact
// distances, and slack so that the shallow edges of a divided smooth surface do not make it small.
// Offline.
#pragma once

#include "core/geometry/sphere.h"
#include "server/model/packing/mesh_distance.h"

namespace hapticd {

struct BallBounds {
  double slack;    ///< > 0, m: how far the ball may stick out of the solid
  double largest;  ///< m, radius
  int refine = 0;  ///< more halvings make the ball larger
};

/// About the largest ball within `bounds` that touches the surface at `p` from inside (`normal`
/// outward, unit). The radius of the result is the distance from `p`. About 10 us.
[[nodiscard]] Sphere inner_ball(const MeshDistance& distance, const Vector3& p,
                                const Vector3& normal, const BallBounds& bounds);

}  // namespace hapticd
