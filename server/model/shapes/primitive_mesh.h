// Closed meshes of simple solids with rounded edges (a sharp edge takes thousands of spheres to
// follow). y up; each solid's frame is stated with it. Curves are cut in chords; `deviation` is how
// far a facet may lie inside the true surface. Every function throws std::invalid_argument naming
// the parameter that is out of its table's range, or that does not go with another. Offline.
#pragma once

#include "server/model/packing/triangle_mesh.h"
#include "server/model/shapes/parameter_field.h"

namespace hapticd {

/// Chords for an arc of `angle` (rad) so that each lies within `deviation` of it; >= 1.
[[nodiscard]] int arc_segments(double radius, double angle, double deviation);

struct PillarParameters {
  double radius = 0.02;        ///< m, [1e-3, 1]
  double height = 0.1;         ///< m, [2e-3, 10], at least twice the rim
  double rim = 0.004;          ///< radius of the rounded rims, m, [1e-5, 1], below `radius`
  double deviation = 0.00005;  ///< m, [1e-6, 1e-2]
};
inline constexpr std::array<ParameterField<PillarParameters>, 4> kPillarFields{{
    {{"radius", "m", 1e-3, 1.0, "radius of the pillar"}, &PillarParameters::radius},
    {{"height", "m", 2e-3, 10.0, "from base to top"}, &PillarParameters::height},
    {{"rim", "m", 1e-5, 1.0, "radius of the rounded rims"}, &PillarParameters::rim},
    {{"deviation", "m", 1e-6, 1e-2, "how far facets may lie inside the surface"},
     &PillarParameters::deviation},
}};
/// A cylinder about the y axis with rounded rims, standing on y = 0.
[[nodiscard]] TriangleMesh make_pillar(const PillarParameters& parameters);

struct PlateParameters {
  double width = 0.3;       ///< along x, m, [1e-3, 10]
  double thickness = 0.02;  ///< along y, m, [1e-3, 10]
  double depth = 0.2;       ///< along z, m, [1e-3, 10]
  double edge = 0.004;      ///< radius of the rounded edges, m, [1e-5, 1], below half of each size
  double deviation = 0.00005;  ///< m, [1e-6, 1e-2]
};
inline constexpr std::array<ParameterField<PlateParameters>, 5> kPlateFields{{
    {{"width", "m", 1e-3, 10.0, "size along x"}, &PlateParameters::width},
    {{"thickness", "m", 1e-3, 10.0, "size along y"}, &PlateParameters::thickness},
    {{"depth", "m", 1e-3, 10.0, "size along z"}, &PlateParameters::depth},
    {{"edge", "m", 1e-5, 1.0, "radius of the rounded edges"}, &PlateParameters::edge},
    {{"deviation", "m", 1e-6, 1e-2, "how far facets may lie inside the surface"},
     &PlateParameters::deviation},
}};
/// A box with rounded edges and corners, centred at the origin.
[[nodiscard]] TriangleMesh make_plate(const PlateParameters& parameters);

struct BarParameters {
  double length = 0.2;         ///< along x, over all, m, [2e-3, 10], more than twice the radius
  double radius = 0.003;       ///< m, [1e-4, 1]
  double deviation = 0.00002;  ///< m, [1e-6, 1e-2]
};
inline constexpr std::array<ParameterField<BarParameters>, 3> kBarFields{{
    {{"length", "m", 2e-3, 10.0, "over all"}, &BarParameters::length},
    {{"radius", "m", 1e-4, 1.0, "radius of the bar"}, &BarParameters::radius},
    {{"deviation", "m", 1e-6, 1e-2, "how far facets may lie inside the surface"},
     &BarParameters::deviation},
}};
/// A bar along x with hemispheres for ends, centred at the origin.
[[nodiscard]] TriangleMesh make_bar(const BarParameters& parameters);

struct EllipsoidParameters {
  double semi_x = 0.02;        ///< half of the size along x, m, [1e-4, 10]
  double semi_y = 0.02;        ///< along y
  double semi_z = 0.02;        ///< along z
  double deviation = 0.00005;  ///< m, [1e-6, 1e-2]
};
inline constexpr std::array<ParameterField<EllipsoidParameters>, 4> kEllipsoidFields{{
    {{"semi_x", "m", 1e-4, 10.0, "half of the size along x"}, &EllipsoidParameters::semi_x},
    {{"semi_y", "m", 1e-4, 10.0, "half of the size along y"}, &EllipsoidParameters::semi_y},
    {{"semi_z", "m", 1e-4, 10.0, "half of the size along z"}, &EllipsoidParameters::semi_z},
    {{"deviation", "m", 1e-6, 1e-2, "how far facets may lie inside the surface"},
     &EllipsoidParameters::deviation},
}};
/// An ellipsoid centred at the origin; a sphere when all are equal.
[[nodiscard]] TriangleMesh make_ellipsoid(const EllipsoidParameters& parameters);

struct BracketParameters {
  double width = 0.08;         ///< along x, m, [1e-2, 10]
  double height = 0.06;        ///< along y, m, [1e-2, 10]
  double length = 0.05;        ///< along z, m, [5e-3, 10]
  double thickness = 0.006;    ///< of base and legs, m, [1e-3, 1]
  double edge = 0.0015;        ///< radius of the rounded edges, m, [1e-5, 1], below thickness / 2
  double fillet = 0.006;       ///< radius of the inner corner, m, [1e-4, 1]
  double legs = 1.0;           ///< 1: an L, 2: a U
  double deviation = 0.00005;  ///< m, [1e-6, 1e-2]
};
inline constexpr std::array<ParameterField<BracketParameters>, 8> kBracketFields{{
    {{"width", "m", 1e-2, 10.0, "size along x"}, &BracketParameters::width},
    {{"height", "m", 1e-2, 10.0, "size along y"}, &BracketParameters::height},
    {{"length", "m", 5e-3, 10.0, "size along z"}, &BracketParameters::length},
    {{"thickness", "m", 1e-3, 1.0, "of base and legs"}, &BracketParameters::thickness},
    {{"edge", "m", 1e-5, 1.0, "radius of the rounded edges"}, &BracketParameters::edge},
    {{"fillet", "m", 1e-4, 1.0, "radius of the inner corner"}, &BracketParameters::fillet},
    {{"legs", "1", 1.0, 2.0, "1: an L, 2: a U"}, &BracketParameters::legs},
    {{"deviation", "m", 1e-6, 1e-2, "how far facets may lie inside the surface"},
     &BracketParameters::deviation},
}};
/// A bracket bent from plate: base on y = 0 along x, a leg upwards at the lower end of x, a second
/// one at the other end of a U. Centred in x and z.
[[nodiscard]] TriangleMesh make_bracket(const BracketParameters& parameters);

}  // namespace hapticd
