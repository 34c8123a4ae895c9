// The small solids: bridge, gum, pegs, feet, markers. See guqin_model.h.
#include <algorithm>
#include <cmath>

#include "server/model/shapes/guqin_model.h"
#include "server/model/shapes/guqin_outline.h"
#include "server/model/shapes/mesh_building.h"

namespace hapticd {
namespace {

/// Sizes that a player does not feel, m: thickness of bridge and gum along x, their length beyond
/// the outer strings, and how deep solids stand in the body at least.
constexpr double kBridgeThickness = 0.009;
constexpr double kGumThickness = 0.01;
constexpr double kBeyondStrings = 0.011;
constexpr double kEmbedded = 0.003;
/// Chords of a quarter of a small circle, and around pegs and markers.
constexpr int kQuarter = 6;
constexpr int kAround = 16;

/// A ridge across the top at x: upright sides, a round crest `height` above the top, `half_length`
/// to both sides, following the arch.
TriangleMesh make_ridge(const GuqinParameters& p, double x, double thickness, double height,
                        double half_length) {
  const double crest = 0.5 * thickness;
  const double bottom = std::min(-kEmbedded, height - crest - kEmbedded);
  const double foot = 0.25 * thickness;
  std::vector<CurvePoint> profile;
  // Halves face each other across x: from the crest down one side, up the other.
  add_quarter(profile, {0.0, height - crest, crest, 1}, kQuarter);
  add_quarter(profile, {foot - crest, bottom + foot, foot, 2}, kQuarter);
  add_quarter(profile, {crest - foot, bottom + foot, foot, 3}, kQuarter);
  add_quarter(profile, {0.0, height - crest, crest, 0}, kQuarter);
  TriangleMesh mesh = extrude(profile, 2.0 * half_length, 0.5 * foot, 3, 24);
  for (Vector3& q : mesh.vertices) q = {x + q.x(), q.y() + guqin_top(p, x, q.z()), q.z()};
  return mesh;
}

/// Profile of revolution from the axis at v = low to the axis at v = high; radii u at heights v
/// between.
std::vector<CurvePoint> turned(double low, std::span<const CurvePoint> side, double high) {
  std::vector<CurvePoint> profile{{0.0, low, 0.0, -1.0}};
  profile.insert(profile.end(), side.begin(), side.end());
  profile.push_back({0.0, high, 0.0, 1.0});
  return profile;
}

/// Height of the middle of the underside at x.
double underside(const GuqinParameters& p, double x, double z) {
  const double s = head_distance(p, x);
  const double half_width = outline_half_width(p, s);
  const double curvature = 2.0 * p.hollow / (half_width * half_width + p.hollow * p.hollow);
  return lower_edge_height(p, s) + p.hollow - arch_fall(curvature, z);
}

}  // namespace

TriangleMesh make_guqin_bridge(const GuqinParameters& parameters) {
  check_guqin(parameters);
  return make_ridge(parameters, 0.5 * parameters.string_length, kBridgeThickness,
                    parameters.bridge_height, 3.0 * parameters.bridge_spacing + kBeyondStrings);
}

TriangleMesh make_guqin_gum(const GuqinParameters& parameters) {
  check_guqin(parameters);
  return make_ridge(parameters, -0.5 * parameters.string_length, kGumThickness,
                    parameters.gum_height, 3.0 * parameters.gum_spacing + kBeyondStrings);
}

TriangleMesh make_guqin_pegs(const GuqinParameters& parameters) {
  check_guqin(parameters);
  constexpr double kLength = 0.034;
  constexpr double kRim = 0.0015;
  // A waisted spindle, wider at its foot, which the player turns.
  std::vector<CurvePoint> side;
  add_quarter(side, {0.0062 - kRim, kRim - kLength, kRim, 3}, 3);
  side.push_back({0.0062, -0.024, 1.0, 0.0});
  side.push_back({0.0054, -0.017, 1.0, 0.0});
  side.push_back({0.004, -0.011, 1.0, 0.0});
  side.push_back({0.0036, -0.006, 1.0, 0.0});
  side.push_back({0.0042, kEmbedded, 1.0, 0.0});
  const TriangleMesh peg = revolve(turned(-kLength, side, kEmbedded), kAround);
  const double x = 0.5 * parameters.string_length + 0.5 * parameters.head - 0.02;
  TriangleMesh mesh;
  for (int i = 0; i < kGuqinStrings; ++i) {
    const double z = (i - 3) * std::min(0.018, parameters.bridge_spacing);
    TriangleMesh part = peg;
    move(part, Matrix3::Identity(), {x, underside(parameters, x, z), z});
    append(mesh, part);
  }
  return mesh;
}

TriangleMesh make_guqin_feet(const GuqinParameters& parameters) {
  check_guqin(parameters);
  constexpr double kHeight = 0.03;
  constexpr double kRim = 0.003;
  constexpr double kPlace = 0.68;  // lambda: between markers 9 and 10
  std::vector<CurvePoint> side;
  add_quarter(side, {0.0135 - kRim, kRim - kHeight, kRim, 3}, kQuarter);
  side.push_back({0.0125, -0.02, 1.0, 0.0});
  side.push_back({0.013, -0.012, 1.0, 0.0});
  side.push_back({0.0165, -0.004, 1.0, 0.0});
  side.push_back({0.0175, 0.0, 1.0, 0.0});
  side.push_back({0.0175, kEmbedded, 1.0, 0.0});
  const TriangleMesh foot = revolve(turned(-kHeight, side, kEmbedded), 2 * kAround);
  const double x = parameters.string_length * (0.5 - kPlace);
  const double z = 0.5 * guqin_half_width(parameters, x);
  TriangleMesh mesh;
  for (const double side_z : {-z, z}) {
    TriangleMesh part = foot;
    move(part, Matrix3::Identity(), {x, underside(parameters, x, side_z), side_z});
    append(mesh, part);
  }
  return mesh;
}

TriangleMesh make_guqin_hui(const GuqinParameters& parameters) {
  check_guqin(parameters);
  const GuqinParameters& p = parameters;
  constexpr double kAbove = 0.0003;  // the discs stand out of the top by this much
  constexpr double kBelow = 0.0009;
  constexpr double kRim = 0.00025;
  TriangleMesh mesh;
  for (std::size_t i = 0; i < kGuqinMarkerPlaces.size(); ++i) {
    const double lambda = kGuqinMarkerPlaces[i];
    const double x = p.string_length * (0.5 - lambda);
    const double string_1 = 3.0 * (p.bridge_spacing + lambda * (p.gum_spacing - p.bridge_spacing));
    // Half way from string 1 to where the edge begins.
    const double z = -0.5 * (string_1 + guqin_half_width(p, x) - p.edge);
    // The one in the middle is the largest.
    const double radius = 0.0055 - 0.004 * std::fabs(lambda - 0.5);
    std::vector<CurvePoint> side;
    add_quarter(side, {radius - kRim, kRim - kBelow, kRim, 3}, 1);
    add_quarter(side, {radius - kRim, kAbove - kRim, kRim, 0}, 1);
    TriangleMesh disc = revolve(turned(-kBelow, side, kAbove), kAround);
    // y to the normal of the arch.
    const double t = z / p.crown_radius;
    const double c = std::sqrt(1.0 - t * t);
    Matrix3 R_W = Matrix3::Identity();
    R_W(1, 1) = c;
    R_W(1, 2) = -t;
    R_W(2, 1) = t;
    R_W(2, 2) = c;
    move(disc, R_W, {x, guqin_top(p, x, z), z});
    append(mesh, disc);
  }
  return mesh;
}

}  // namespace hapticd
