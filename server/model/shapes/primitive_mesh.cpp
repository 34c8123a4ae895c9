// See primitive_mesh.h.
#include "server/model/shapes/primitive_mesh.h"

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"
#include "server/model/shapes/mesh_building.h"

namespace hapticd {
namespace {

// Where a surface bends both ways the depths of the chords add up: each gets half the deviation.

void require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

/// The corner of a fillet: as add_quarter, but on the solid's inner side and the other way round,
/// so that the normals point to the centre.
void add_fillet(std::vector<CurvePoint>& curve, QuarterCircle inner, int segments) {
  const std::size_t begin = curve.size();
  inner.radius = -inner.radius;
  add_quarter(curve, inner, segments);
  std::reverse(curve.begin() + static_cast<std::ptrdiff_t>(begin), curve.end());
}

/// Loop of a rectangle (half sizes hx, hz, without its corners) with corners of radius r at height
/// y.
Loop rounded_rectangle(double hx, double hz, double r, double y, int segments) {
  std::vector<CurvePoint> curve;
  add_quarter(curve, {hx, hz, r, 0}, segments);
  add_quarter(curve, {-hx, hz, r, 1}, segments);
  add_quarter(curve, {-hx, -hz, r, 2}, segments);
  add_quarter(curve, {hx, -hz, r, 3}, segments);
  Loop loop;
  for (const CurvePoint& point : curve) loop.emplace_back(point.u, y, -point.v);
  return loop;
}

/// Profile of the L or U (see make_bracket), from the first leg's top round the outside and back.
std::vector<CurvePoint> bracket_profile(const BracketParameters& p, int edge, int fillet) {
  const double r = p.edge;
  const double left = -0.5 * p.width;
  const double right = 0.5 * p.width;
  const double t = p.thickness;
  const bool is_u = p.legs == 2.0;
  std::vector<CurvePoint> curve;
  add_quarter(curve, {left + r, p.height - r, r, 1}, edge);
  add_quarter(curve, {left + r, r, r, 2}, fillet);
  add_quarter(curve, {right - r, r, r, 3}, is_u ? fillet : edge);
  add_quarter(curve, {right - r, (is_u ? p.height : t) - r, r, 0}, edge);
  if (is_u) {
    add_quarter(curve, {right - t + r, p.height - r, r, 1}, edge);
    add_fillet(curve, {right - t - p.fillet, t + p.fillet, p.fillet, 1}, fillet);
  }
  add_fillet(curve, {left + t + p.fillet, t + p.fillet, p.fillet, 0}, fillet);
  add_quarter(curve, {left + t - r, p.height - r, r, 0}, edge);
  return curve;
}

}  // namespace

int arc_segments(double radius, double angle, double deviation) {
  // The sagitta of a chord over the angle 2 a is r (1 - cos a) < r a^2 / 2.
  const double half_angle = std::sqrt(2.0 * deviation / radius);
  return std::max(1, static_cast<int>(std::ceil(0.5 * angle / half_angle)));
}

TriangleMesh make_pillar(const PillarParameters& parameters) {
  const PillarParameters& p = parameters;
  check_parameters("pillar", kPillarFields, p);
  require(p.rim < p.radius, "pillar: rim must be below radius");
  require(p.height > 2.0 * p.rim, "pillar: height must be above twice the rim");
  const int around = std::max(8, arc_segments(p.radius, 2.0 * kPi, 0.5 * p.deviation));
  const int rim = arc_segments(p.rim, 0.5 * kPi, 0.5 * p.deviation);
  std::vector<CurvePoint> profile{{0.0, 0.0, 0.0, -1.0}};
  add_quarter(profile, {p.radius - p.rim, p.rim, p.rim, 3}, rim);
  add_quarter(profile, {p.radius - p.rim, p.height - p.rim, p.rim, 0}, rim);
  profile.push_back({0.0, p.height, 0.0, 1.0});
  return revolve(profile, around);
}

TriangleMesh make_plate(const PlateParameters& parameters) {
  const PlateParameters& p = parameters;
  check_parameters("plate", kPlateFields, p);
  require(2.0 * p.edge < std::min({p.width, p.thickness, p.depth}),
          "plate: edge must be below half of width, thickness and depth");
  const int segments = arc_segments(p.edge, 0.5 * kPi, 0.5 * p.deviation);
  const double half_height = 0.5 * p.thickness - p.edge;
  // Radius of the corners and height of each loop, as a quarter of a circle below and above.
  std::vector<CurvePoint> profile;
  add_quarter(profile, {0.0, -half_height, p.edge, 3}, segments);
  add_quarter(profile, {0.0, half_height, p.edge, 0}, segments);
  std::vector<Loop> loops;
  loops.reserve(profile.size());
  for (const CurvePoint& point : profile) {
    loops.push_back(rounded_rectangle(0.5 * p.width - p.edge, 0.5 * p.depth - p.edge, point.u,
                                      point.v, segments));
  }
  return loft(loops);
}

TriangleMesh make_bar(const BarParameters& parameters) {
  const BarParameters& p = parameters;
  check_parameters("bar", kBarFields, p);
  require(p.length > 2.0 * p.radius, "bar: length must be above twice the radius");
  const int quarter = std::max(2, arc_segments(p.radius, 0.5 * kPi, 0.5 * p.deviation));
  const double half_length = 0.5 * p.length - p.radius;
  std::vector<CurvePoint> profile;
  add_quarter(profile, {0.0, -half_length, p.radius, 3}, quarter);
  add_quarter(profile, {0.0, half_length, p.radius, 0}, quarter);
  TriangleMesh mesh = revolve(profile, 4 * quarter);
  Matrix3 R_xy = Matrix3::Zero();  // y to x, x to -y
  R_xy(0, 1) = 1.0;
  R_xy(1, 0) = -1.0;
  R_xy(2, 2) = 1.0;
  move(mesh, R_xy, {0.0, 0.0, 0.0});
  return mesh;
}

TriangleMesh make_ellipsoid(const EllipsoidParameters& parameters) {
  const EllipsoidParameters& p = parameters;
  check_parameters("ellipsoid", kEllipsoidFields, p);
  // A triangle of edge l has its centre l^2 / 6 below the unit sphere; the longest edge is 1.33 /
  // frequency, and stretching by the semi-axes stretches the depth by the longest at most.
  const double longest = std::max({p.semi_x, p.semi_y, p.semi_z});
  const double frequency = 1.33 * std::sqrt(longest / (6.0 * p.deviation));
  require(frequency < 1000.0, "ellipsoid: deviation too small for its size");
  TriangleMesh mesh = geodesic_sphere(std::max(2, static_cast<int>(std::ceil(frequency))));
  for (Vector3& q : mesh.vertices) q = {q.x() * p.semi_x, q.y() * p.semi_y, q.z() * p.semi_z};
  return mesh;
}

TriangleMesh make_bracket(const BracketParameters& parameters) {
  const BracketParameters& p = parameters;
  check_parameters("bracket", kBracketFields, p);
  require(p.legs == 1.0 || p.legs == 2.0, "bracket: legs must be 1 or 2");
  require(2.0 * p.edge < p.thickness, "bracket: edge must be below half of thickness");
  require(2.0 * p.edge < p.length, "bracket: edge must be below half of length");
  const double inner = p.thickness + p.fillet;
  require(inner + p.edge < p.height && p.legs * inner + p.edge < p.width,
          "bracket: thickness and fillet too large for width and height");
  const int edge = arc_segments(p.edge, 0.5 * kPi, 0.5 * p.deviation);
  const int fillet = arc_segments(p.fillet, 0.5 * kPi, 0.5 * p.deviation);
  const std::vector<CurvePoint> profile = bracket_profile(p, edge, fillet);
  // Only half of the edge at the ends, so that the profile's corners keep a radius there.
  return extrude(profile, p.length, 0.5 * p.edge, edge, 1);
}

}  // namespace hapticd
