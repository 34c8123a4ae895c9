// The body: cross-sections lofted from tail to head. See guqin_model.h.
#include "server/model/shapes/guqin_model.h"

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"
#include "server/model/shapes/guqin_outline.h"
#include "server/model/shapes/mesh_building.h"

namespace hapticd {
namespace {

/// Chords of half a cross-section: along the arch and round an edge. More draws finer and costs
/// triangles in proportion: 8 and 4 leave the arch 60 um inside its circle.
constexpr int kArchSegments = 8;
constexpr int kEdgeSegments = 4;
/// Radius of the end's rounding as a share of the edge's: below 1, so that the corners of the end
/// keep a radius.
constexpr double kEndEdge = 0.7;
/// Cross-sections stand closer by this factor where the outline bends.
constexpr double kBendFactor = 0.4;

/// One half of a cross-section's upper or lower side, from the middle to the side of the body: an
/// arch of curvature k about y0, then the edge. u = z, v = y; `up` is 1 above and -1 below.
std::vector<CurvePoint> half_side(double half_width, double edge, double y0, double k, double up) {
  // The arch ends where its parallel at depth `edge` reaches the centre of the edge's circle.
  const double z_end = (half_width - edge) / (1.0 - up * edge * k);
  std::vector<CurvePoint> curve;
  for (int j = 0; j <= kArchSegments; ++j) {
    const double z = z_end * j / kArchSegments;
    const double t = k * z;
    curve.push_back({z, y0 - arch_fall(k, z), up * t, up * std::sqrt(1.0 - t * t)});
  }
  const CurvePoint arch_end = curve.back();
  const double centre_z = arch_end.u - edge * arch_end.normal_u;
  const double centre_y = arch_end.v - edge * arch_end.normal_v;
  const double begin = arctangent2(up * arch_end.normal_v, arch_end.normal_u);
  for (int j = 1; j <= kEdgeSegments; ++j) {
    SinCos turn = sin_cos(begin * (kEdgeSegments - j) / kEdgeSegments);
    turn.sin *= up;
    curve.push_back({centre_z + edge * turn.cos, centre_y + edge * turn.sin, turn.cos, turn.sin});
  }
  return curve;
}

/// The whole loop, from the upper end of the side z < 0 over the top and back below, at x, drawn in
/// by `inset` along the normals.
Loop cross_section(const GuqinParameters& p, double s, double inset) {
  const double half_width = outline_half_width(p, s);
  const double low = lower_edge_height(p, s);
  const double hollow_curvature = 2.0 * p.hollow / (half_width * half_width + p.hollow * p.hollow);
  const std::vector<CurvePoint> upper =
      half_side(half_width, p.edge, crown_height(p, s), 1.0 / p.crown_radius, 1.0);
  const std::vector<CurvePoint> lower =
      half_side(half_width, p.edge, low + p.hollow, hollow_curvature, -1.0);
  const double x = head_distance_to_x(p, s);
  Loop loop;
  const auto add = [&](const CurvePoint& point, double side) {
    loop.emplace_back(x, point.v - inset * point.normal_v,
                      side * (point.u - inset * point.normal_u));
  };
  for (std::size_t i = upper.size() - 1; i > 0; --i) add(upper[i], -1.0);
  for (const CurvePoint& point : upper) add(point, 1.0);
  for (std::size_t i = lower.size() - 1; i > 0; --i) add(lower[i], 1.0);
  for (const CurvePoint& point : lower) add(point, -1.0);
  return loop;
}

/// Distances of the cross-sections from the head's end, without the rounded ends, in order.
std::vector<double> station_places(const GuqinParameters& p, double end_edge) {
  // At the plan corners the outline bends more and more towards the end.
  std::vector<double> places{end_edge, 0.006, 0.009, 0.014};
  double s = places.back();
  const double last = p.length - s;
  const auto advance = [&](double end, double spacing) {
    const int pieces = std::max(1, static_cast<int>(std::ceil((end - s) / spacing)));
    for (int k = 1; k <= pieces; ++k) places.push_back(s + (end - s) * k / pieces);
    s = end;
  };
  for (const OutlineBend& bend : outline_bends(p)) {
    advance(bend.begin, p.station);
    advance(bend.end, p.station * kBendFactor);
  }
  advance(last, p.station);
  places.insert(places.end(), {p.length - 0.009, p.length - 0.006, p.length - end_edge});
  return places;
}

}  // namespace

double guqin_half_width(const GuqinParameters& parameters, double x) {
  return outline_half_width(parameters, head_distance(parameters, x));
}

double guqin_top(const GuqinParameters& parameters, double x, double z) {
  return crown_height(parameters, head_distance(parameters, x)) -
         arch_fall(1.0 / parameters.crown_radius, z);
}

TriangleMesh make_guqin_body(const GuqinParameters& parameters) {
  check_guqin(parameters);
  const double end_edge = kEndEdge * parameters.edge;
  // Where each cross-section stands and how far it is drawn in: rounded at both ends.
  struct Station {
    double s, inset;
  };
  std::vector<Station> stations;
  std::vector<CurvePoint> rounding;
  add_quarter(rounding, {0.0, 0.0, end_edge, 0}, kEdgeSegments);
  for (std::size_t k = rounding.size() - 1; k > 0; --k) {
    stations.push_back({end_edge - rounding[k].v, end_edge - rounding[k].u});
  }
  for (const double s : station_places(parameters, end_edge)) stations.push_back({s, 0.0});
  for (std::size_t k = 1; k < rounding.size(); ++k) {
    stations.push_back({parameters.length - end_edge + rounding[k].v, end_edge - rounding[k].u});
  }
  // From tail to head, so that x grows.
  std::vector<Loop> loops;
  for (auto station = stations.rbegin(); station != stations.rend(); ++station) {
    loops.push_back(cross_section(parameters, station->s, station->inset));
  }
  return loft(loops);
}

}  // namespace hapticd
