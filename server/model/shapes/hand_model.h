// A hand in the pose that plucks a Guqin: palm down, index finger stretched out and inclined, the
// others bent and held above it. One mesh for palm and fingers, and for each finger a pad and a
// separate nail, so that contact can be finer there.
//
// Frame G of the tool: y up, the fingers point along -z, the palm faces -y, the thumb of a right
// hand lies at x < 0. Origin: straight above the lowest point of the index finger's pad, at the
// height of the pad's centre; so pressing straight down with the index finger turns nothing. With
// the frame of the Guqin's scene, the hand of a player who sits at z > 0 has no rotation.
// Deterministic to the bit. Functions throw std::invalid_argument naming the parameter. Offline.
#pragma once

#include "server/model/packing/triangle_mesh.h"
#include "server/model/shapes/parameter_field.h"

namespace hapticd {

struct HandParameters {
  double length = 0.18;  ///< from wrist to the foremost finger, all scaled, m, [0.1, 0.3]
  double left = 0.0;     ///< 1: the mirror image, a left hand
  double cell =
      0.0045;  ///< about the size of the hand's triangles, m, [1.5e-3, 0.01], at most length / 30
  double tip_deviation = 8e-5;   ///< of the pads' facets from their ellipsoids, m, [5e-6, 1e-3]
  double nail_thickness = 9e-4;  ///< m, [3e-4, 2e-3]
  double nail_reach = 0.0018;    ///< of the nails beyond the pads, m, [0, 0.01]
};
inline constexpr std::array<ParameterField<HandParameters>, 6> kHandFields{{
    {{"length", "m", 0.1, 0.3, "of the hand; all of it is scaled"}, &HandParameters::length},
    {{"left", "1", 0.0, 1.0, "1: a left hand, the mirror image"}, &HandParameters::left},
    {{"cell", "m", 1.5e-3, 0.01, "about the size of the hand's triangles"}, &HandParameters::cell},
    {{"tip_deviation", "m", 5e-6, 1e-3, "how far the facets of the pads may lie inside"},
     &HandParameters::tip_deviation},
    {{"nail_thickness", "m", 3e-4, 2e-3, "thickness of the nails"},
     &HandParameters::nail_thickness},
    {{"nail_reach", "m", 0.0, 0.01, "how far the nails reach beyond the pads"},
     &HandParameters::nail_reach},
}};

enum class Finger : std::uint8_t { kThumb, kIndex, kMiddle, kRing, kLittle };
inline constexpr int kFingers = 5;

/// The pad of a finger: an ellipsoid. Columns of R_G: across the finger, out of its back, along it
/// towards the tip.
struct FingerPad {
  Vector3 p_G{0.0, 0.0, 0.0};         ///< centre, m
  Matrix3 R_G = Matrix3::Identity();  ///< right-handed for a right hand, mirrored for a left one
  Vector3 semi_axes{0.0, 0.0, 0.0};   ///< m, along the columns
};
[[nodiscard]] FingerPad finger_pad(const HandParameters& parameters, Finger finger);

/// Palm and fingers without pads and nails.
[[nodiscard]] TriangleMesh make_hand(const HandParameters& parameters);
/// Pad at the end of a finger; overlaps the finger.
[[nodiscard]] TriangleMesh make_finger_tip(const HandParameters& parameters, Finger finger);
/// Nail on the back of the pad: a bent plate with a round rim.
[[nodiscard]] TriangleMesh make_finger_nail(const HandParameters& parameters, Finger finger);

}  // namespace hapticd
