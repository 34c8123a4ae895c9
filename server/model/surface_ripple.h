// How rippled the surface of a sphere-tree is, from the tree alone: what is left of it in patches
// of a few millimetres beside the quadratic surfaces nearest to them. Offline.
#pragma once

#include "core/tree/sphere_tree.h"

namespace hapticd {

/// What a tip of kRippleTip feels.
struct SurfaceRipple {
  double height = 0.0;  ///< rms of its centre's place along the normal, m
  double angle = 0.0;   ///< rms of the normal's direction, rad
  int patches = 0;      ///< that this is the median of; 0: the tree is too small or too curved
};

/// Radius of the tip, m.
inline constexpr double kRippleTip = 5e-3;

/// Deterministic. About 0.2 s.
[[nodiscard]] SurfaceRipple measure_ripple(const SphereTree& tree);

}  // namespace hapticd
