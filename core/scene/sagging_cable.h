// A slack cable as a chain of strings: its rest shape is a parabola, drawn and touched as straight
// pieces, each of which yields between its own ends. Deviation: a cable yields as a whole; here the
// knots between the pieces stay where they are, and a piece pushed in its middle yields as the
// whole cable would there. Offline.
#pragma once

#include <vector>

#include "core/scene/scene_description.h"

namespace hapticd {

/// Sag up to which three pieces represent a cable, m: they stray from it by 0.25 mm at most.
/// Larger: fewer pieces for more cables, which stray further.
inline constexpr double kSlightSag = 2.25e-3;
/// Pieces of a cable, at most. Odd, so that the middle, where a cable is mostly pushed aside, is no
/// knot; more would follow the parabola closer, but yield less far between their knots.
inline constexpr int kMaxCablePieces = 5;

/// Pieces of a string with this sag (m, >= 0): 1 when it is straight.
[[nodiscard]] int cable_pieces(double sag) noexcept;

/// Largest distance between the pieces and the parabola, m: sag / pieces^2.
[[nodiscard]] double cable_error(double sag) noexcept;

/// The pieces of `string`, from A to B; the string itself when it has no sag. Tension and stiffness
/// of each are such that it yields in its middle, to first and third order, as a string from A to B
/// would there.
[[nodiscard]] std::vector<StringParameters> cable_of(const StringDescription& string);

}  // namespace hapticd
