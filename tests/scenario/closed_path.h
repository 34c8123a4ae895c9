// Closed ways of a hand about a place of a scene: it comes down on an obstacle, moves about on it,
// lifts, and is back where it began, lap after lap. Not RT.
#pragma once

#include <array>

#include "core/scene/scene.h"
#include "tests/support/random.h"

namespace hapticd::test {

/// A lap of one hand. Frames: W. `share` of the lap runs from 0 to 1.
struct ClosedPath {
  Pose X_WH;                     ///< lifted; where the lap begins and ends
  Vector3 down;                  ///< from there to the deepest place, m
  std::array<Vector3, 2> aside;  ///< amplitudes of sin(2 pi share) and sin(4 pi share + 1), m
  std::array<Vector3, 2> turn;   ///< of the rotation vector likewise, rad
  int ticks = 0;                 ///< of a lap

  /// Where the hand is.
  [[nodiscard]] Pose at(double share) const;
};

/// A random lap of `tool` over a string, a line or a body, `depth` (m) deep at most: with a leaf of
/// its own on the surface, aside by up to `width` (m), and along a string by up to a third of it.
[[nodiscard]] ClosedPath random_lap(const ToolScene& view, const Pose& X_WH, SplitMix64& random);

}  // namespace hapticd::test
