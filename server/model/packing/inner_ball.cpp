// See inner_ball.h.
#include "server/model/packing/inner_ball.h"

#include <algorithm>

namespace hapticd {
namespace {

/// Most steps of shrinking. Normal value 40 (6 on average); fewer may leave a ball that sticks out,
/// which callers measure.
constexpr int kSteps = 40;
/// Least and largest share of the radius that a step keeps: it always shrinks, but not to nothing
/// by the rounding of one point near `p`.
constexpr double kMinKept = 0.05;
constexpr double kMaxKept = 0.95;

}  // namespace

Sphere inner_ball(const MeshDistance& distance, const Vector3& p, const Vector3& normal,
                  const BallBounds& bounds) {
  double r = bounds.largest;
  double too_large = r;
  for (int step = 0; step < kSteps; ++step) {
    NearestPoint nearest;
    // Signed: behind the far wall of a thin solid the surface may be far again.
    if (-distance.signed_distance(p - r * normal, nearest) >= r - bounds.slack) break;
    // The ball through the nearest point that touches at p.
    const Vector3 chord = p - nearest.p;
    const double along = chord.dot(normal);
    const double through = along > 0.0 ? chord.squaredNorm() / (2.0 * along) : r;
    too_large = r;
    r = std::clamp(through, kMinKept * r, kMaxKept * r);
  }
  for (int step = 0; step < bounds.refine && too_large > r; ++step) {
    const double middle = 0.5 * (r + too_large);
    const bool fits = -distance.signed_distance(p - middle * normal) >= middle - bounds.slack;
    (fits ? r : too_large) = middle;
  }
  return {p - r * normal, r};
}

}  // namespace hapticd
