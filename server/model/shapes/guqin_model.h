// A Guqin by parameters: body, bridge (yueshan), dragon's gum (longyin), pegs (zhen), feet (yanzu),
// markers (hui) and the places of its seven strings. Each solid is a closed mesh with rounded
// edges; where one stands on another they overlap by a few millimetres.
//
// Frame W: the player sits at z > 0 and looks towards -z, with the head of the instrument to the
// right. x along the strings, from the gum to the bridge; y up; z across. Origin: middle of string
// 4, with y = 0 on the crown of the top. String 1, the lowest, lies farthest from the player (z <
// 0), the markers beyond it. lambda along a string is 0 at the bridge (A) and 1 at the gum (B).
// Deterministic to the bit. Functions throw std::invalid_argument naming the parameter. Offline.
#pragma once

#include "server/model/packing/triangle_mesh.h"
#include "server/model/shapes/parameter_field.h"

namespace hapticd {

inline constexpr int kGuqinStrings = 7;
inline constexpr int kGuqinMarkers = 13;

/// Dimensions of the instrument; ranges in kGuqinFields. All in m.
struct GuqinParameters {
  double length = 1.22;          ///< of the body, [0.6, 2]
  double string_length = 1.1;    ///< from crest of bridge to crest of gum, along x, [0.4, 1.9]
  double head = 0.095;           ///< from the head's end to the bridge's crest, [0.05, 0.3]
  double shoulder_width = 0.2;   ///< widest place, [0.12, 0.4]
  double head_width = 0.176;     ///< at the head's end, [0.1, 0.4]
  double tail_width = 0.136;     ///< at the tail's end, [0.1, 0.4]
  double neck = 0.013;           ///< depth of the indentation between head and shoulder, [0, 0.03]
  double waist = 0.01;           ///< depth of the indentation at markers 8 to 11, [0, 0.03]
  double thickness = 0.055;      ///< from the crown to the lowest edge, [0.03, 0.1]
  double end_thickness = 0.042;  ///< the same at head and tail, [0.025, 0.1]
  double crown_radius = 0.34;    ///< radius of the top's arch across, [0.22, 10]
  double hollow = 0.002;         ///< how far the underside is hollowed, [0, 0.01]
  double edge = 0.006;           ///< radius of the rounded edges, [0.002, 0.012]
  double bridge_height = 0.01;   ///< of the bridge's crest above the top, [0.004, 0.03]
  double gum_height = 0.0025;    ///< of the gum's crest above the top, [0.001, 0.02]
  double bridge_spacing = 0.02;  ///< of the strings at the bridge, across, [0.01, 0.04]
  double gum_spacing = 0.014;    ///< at the gum, [0.008, 0.04]
  double string_radius = 0.00034;  ///< of string 7, the thinnest, [1e-4, 1e-3]
  double rest_gap = 0.00005;       ///< between a string and the crests it rests on, [0, 1e-3]
  double station = 0.018;          ///< distance of the body's cross-sections, [0.004, 0.05]
};

inline constexpr std::array<ParameterField<GuqinParameters>, 20> kGuqinFields{{
    {{"length", "m", 0.6, 2.0, "of the body"}, &GuqinParameters::length},
    {{"string_length", "m", 0.4, 1.9, "between the crests of bridge and gum"},
     &GuqinParameters::string_length},
    {{"head", "m", 0.05, 0.3, "from the head's end to the bridge"}, &GuqinParameters::head},
    {{"shoulder_width", "m", 0.12, 0.4, "widest place"}, &GuqinParameters::shoulder_width},
    {{"head_width", "m", 0.1, 0.4, "width of the head's end"}, &GuqinParameters::head_width},
    {{"tail_width", "m", 0.1, 0.4, "width of the tail's end"}, &GuqinParameters::tail_width},
    {{"neck", "m", 0.0, 0.03, "depth of the indentation behind the head"}, &GuqinParameters::neck},
    {{"waist", "m", 0.0, 0.03, "depth of the indentation at markers 8 to 11"},
     &GuqinParameters::waist},
    {{"thickness", "m", 0.03, 0.1, "from the crown to the lowest edge"},
     &GuqinParameters::thickness},
    {{"end_thickness", "m", 0.025, 0.1, "thickness at head and tail"},
     &GuqinParameters::end_thickness},
    {{"crown_radius", "m", 0.22, 10.0, "radius of the top's arch"}, &GuqinParameters::crown_radius},
    {{"hollow", "m", 0.0, 0.01, "how far the underside is hollowed"}, &GuqinParameters::hollow},
    {{"edge", "m", 0.002, 0.012, "radius of the rounded edges"}, &GuqinParameters::edge},
    {{"bridge_height", "m", 0.004, 0.03, "crest of the bridge above the top"},
     &GuqinParameters::bridge_height},
    {{"gum_height", "m", 0.001, 0.02, "crest of the gum above the top"},
     &GuqinParameters::gum_height},
    {{"bridge_spacing", "m", 0.01, 0.04, "of the strings at the bridge"},
     &GuqinParameters::bridge_spacing},
    {{"gum_spacing", "m", 0.008, 0.04, "of the strings at the gum"}, &GuqinParameters::gum_spacing},
    {{"string_radius", "m", 1e-4, 1e-3, "of string 7"}, &GuqinParameters::string_radius},
    {{"rest_gap", "m", 0.0, 1e-3, "between a string and the crests it rests on"},
     &GuqinParameters::rest_gap},
    {{"station", "m", 0.004, 0.05, "distance of the body's cross-sections"},
     &GuqinParameters::station},
}};

/// Places of the markers, 1 to 13, as lambda.
inline constexpr std::array<double, kGuqinMarkers> kGuqinMarkerPlaces{
    1.0 / 8, 1.0 / 6, 1.0 / 5, 1.0 / 4, 1.0 / 3, 2.0 / 5, 1.0 / 2,
    3.0 / 5, 2.0 / 3, 3.0 / 4, 4.0 / 5, 5.0 / 6, 7.0 / 8};

/// Height y of the top above W's origin at (x, z), m; |z| at most half the width there less the
/// rounded edge, x on the body.
[[nodiscard]] double guqin_top(const GuqinParameters& parameters, double x, double z);

/// Half the width of the body at x, m.
[[nodiscard]] double guqin_half_width(const GuqinParameters& parameters, double x);

/// The body, one closed solid of about 10 000 triangles.
[[nodiscard]] TriangleMesh make_guqin_body(const GuqinParameters& parameters);
/// The bridge: a rounded ridge across, one solid.
[[nodiscard]] TriangleMesh make_guqin_bridge(const GuqinParameters& parameters);
/// The dragon's gum: a low ridge across, one solid.
[[nodiscard]] TriangleMesh make_guqin_gum(const GuqinParameters& parameters);
/// Seven pegs under the head, separate solids in one mesh; for drawing.
[[nodiscard]] TriangleMesh make_guqin_pegs(const GuqinParameters& parameters);
/// Two feet under the waist, separate solids in one mesh; for drawing.
[[nodiscard]] TriangleMesh make_guqin_feet(const GuqinParameters& parameters);
/// Thirteen discs let into the top, separate solids in one mesh; for drawing.
[[nodiscard]] TriangleMesh make_guqin_hui(const GuqinParameters& parameters);

}  // namespace hapticd
