// Outlines of flat shapes for tests, of kinds that meshes have, and what is true of them, in long
// double. They turn left; places in no unit.
#pragma once

#include <array>
#include <vector>

#include "tests/support/random.h"

namespace hapticd::test {

using Real = long double;
using Point = std::array<Real, 2>;
/// Corners in order; the first is not repeated.
using Outline = std::vector<Point>;

/// Positive: turns left.
[[nodiscard]] Real shoelace(const Outline& outline);

/// By the crossings of a ray to the right.
[[nodiscard]] bool contains(const Outline& outline, const Point& q);

/// From `q` to the nearest edge.
[[nodiscard]] Real distance(const Outline& outline, const Point& q);

/// Corners around the origin at growing angles; radii from `least` to 1.
[[nodiscard]] Outline around(SplitMix64& random, std::size_t corners, double least);

/// Corners on an ellipse.
[[nodiscard]] Outline ellipse(SplitMix64& random, std::size_t corners);

/// A back with teeth of random length, all corners at right angles: an L, a U, an E and longer.
[[nodiscard]] Outline comb(SplitMix64& random, std::size_t teeth);

/// Stairs of whole numbers, an L and longer: corners stand on the lines through others.
[[nodiscard]] Outline stairs(SplitMix64& random, std::size_t steps);

/// A corridor that winds inwards, `turns` right angles each way.
[[nodiscard]] Outline spiral(int turns);

/// A square with a square hole, joined by an edge there and back.
[[nodiscard]] Outline ring(SplitMix64& random);

/// Corners put on the edges of `outline`.
[[nodiscard]] Outline with_corners_on_edges(SplitMix64& random, const Outline& outline);

}  // namespace hapticd::test
