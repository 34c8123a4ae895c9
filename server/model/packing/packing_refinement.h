// Balls that cover a surface, made better: every piece of surface goes to the ball that needs the
// least growth to contain it, every ball moves to where its pieces need least growth, superfluous
// balls go, new ones come where the growth is large (after R. Wang et al., "Variational sphere set
// approximation for solid objects", The Visual Computer 2006, with the exact largest distance
// instead of a volume). Offline.
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/sphere.h"
#include "server/model/packing/surface_patches.h"

namespace hapticd {

/// The balls and what they have to contain.
struct BallSet {
  /// Centres; the radius is the depth of the centre in the solid, m (negative outside).
  std::vector<Sphere> balls;
  /// Of every piece of ball k the corner farthest from it: points[first[k]] ... points[first[k + 1]
  /// - 1]. All pieces together are the surface.
  std::vector<std::int64_t> first;
  std::vector<Vector3> points;
  /// Growth by which ball k contains its pieces, and so sticks out at most: radius minus depth, m.
  /// Minus infinity where it has none.
  std::vector<double> growth;
  /// Growth that the other balls would need to take over all of ball k's pieces; infinite where no
  /// other is near.
  std::vector<double> growth_without;
};

struct AssignOptions {
  double scale = 0.0;  ///< growth that matters, m: pieces are cut where that saves a share of it
  int cuts = 3;        ///< most times a patch is cut in four
  int threads = 1;
};

/// Gives every piece of the surface to the ball that needs the least growth for it, and sets all
/// but `balls`. At least one ball.
void assign_pieces(const SurfacePatches& surface, const AssignOptions& options, BallSet& set);

/// Moves every ball that has points to where they need less growth, in up to `trials` trials; sets
/// only `balls`. Growth below `scale` (m) times 1e-3 does not matter.
void move_balls(const MeshDistance& distance, int trials, double scale, int threads, BallSet& set);

/// Largest growth, m.
[[nodiscard]] double largest_growth(const BallSet& set);

}  // namespace hapticd
