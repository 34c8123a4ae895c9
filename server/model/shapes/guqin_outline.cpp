// See guqin_outline.h.
#include "server/model/shapes/guqin_outline.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace hapticd {
namespace {

/// Where the outline is widest, as a share of the length: about marker 3.
constexpr double kShoulder = 0.24;
/// The indentations begin, are deep, begin to end, end: as shares of the length. The neck's flank
/// towards the head is the steeper one; the waist lies between markers 8 and 11.
constexpr std::array<double, 4> kNeck{0.084, 0.116, 0.136, 0.225};
constexpr std::array<double, 4> kWaist{0.605, 0.645, 0.775, 0.815};
/// Radius of the corners in plan, m.
constexpr double kPlanCorner = 0.014;
/// How far the crown falls from bridge to head's end and from gum to tail's end, m.
constexpr double kHeadFall = 0.005;
constexpr double kTailFall = 0.003;
/// Over this much of the length the underside rises towards each end.
constexpr double kTaper = 0.2;
/// Strings keep at least this much wood beside them, m.
constexpr double kBesideStrings = 0.012;
/// Least height of the body's sides between the rounded edges, m.
constexpr double kMinSide = 0.002;
/// Least length of the body behind the gum, m.
constexpr double kMinTail = 0.015;

double bump(const std::array<double, 4>& shares, double share) {
  return smooth_step((share - shares[0]) / (shares[1] - shares[0])) -
         smooth_step((share - shares[2]) / (shares[3] - shares[2]));
}

/// How much narrower the outline is at distance `d` from an end than further on.
double corner_inset(double d) {
  if (d >= kPlanCorner) return 0.0;
  const double rest = kPlanCorner - std::max(d, 0.0);
  return kPlanCorner - std::sqrt(kPlanCorner * kPlanCorner - rest * rest);
}

void require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

}  // namespace

double smooth_step(double t) {
  const double c = std::clamp(t, 0.0, 1.0);
  return c * c * (3.0 - 2.0 * c);
}

double arch_fall(double curvature, double z) {
  const double t = curvature * z;
  return z * t / (1.0 + std::sqrt(1.0 - t * t));
}

double head_distance(const GuqinParameters& parameters, double x) {
  return parameters.head + 0.5 * parameters.string_length - x;
}

double head_distance_to_x(const GuqinParameters& parameters, double s) {
  return parameters.head + 0.5 * parameters.string_length - s;
}

double outline_half_width(const GuqinParameters& parameters, double s) {
  const GuqinParameters& p = parameters;
  const double share = s / p.length;
  double width = p.shoulder_width;
  if (share < kShoulder) {
    width += (p.head_width - p.shoulder_width) * (1.0 - smooth_step(share / kShoulder));
  } else {
    // Level at the shoulder, nearly straight towards the tail.
    const double t = std::min(1.0, (share - kShoulder) / (1.0 - kShoulder));
    width += (p.tail_width - p.shoulder_width) * t * t * (2.0 - t);
  }
  return 0.5 * width - p.neck * bump(kNeck, share) - p.waist * bump(kWaist, share) -
         corner_inset(s) - corner_inset(p.length - s);
}

double crown_height(const GuqinParameters& parameters, double s) {
  const double tail = parameters.length - parameters.head - parameters.string_length;
  const double from_tail = parameters.length - s;
  return -kHeadFall * smooth_step(1.0 - s / parameters.head) -
         kTailFall * smooth_step(1.0 - from_tail / tail);
}

double lower_edge_height(const GuqinParameters& parameters, double s) {
  const GuqinParameters& p = parameters;
  const double taper = kTaper * p.length;
  const double ends = smooth_step(1.0 - s / taper) + smooth_step(1.0 - (p.length - s) / taper);
  return -p.thickness + (p.thickness - p.end_thickness) * ends;
}

std::array<OutlineBend, 4> outline_bends(const GuqinParameters& parameters) {
  const double length = parameters.length;
  return {OutlineBend{kNeck[0] * length, kNeck[1] * length},
          OutlineBend{kNeck[2] * length, kNeck[3] * length},
          OutlineBend{kWaist[0] * length, kWaist[1] * length},
          OutlineBend{kWaist[2] * length, kWaist[3] * length}};
}

void check_guqin(const GuqinParameters& parameters) {
  const GuqinParameters& p = parameters;
  check_parameters("guqin", kGuqinFields, p);
  require(p.head + p.string_length + kMinTail <= p.length,
          "guqin: length must be at least head + string_length + 0.015 m");
  require(p.shoulder_width >= p.head_width && p.shoulder_width >= p.tail_width,
          "guqin: shoulder_width must be at least head_width and tail_width");
  require(p.end_thickness <= p.thickness, "guqin: end_thickness must be at most thickness");
  const double half_length = 0.5 * p.string_length;
  for (const double end : {half_length, -half_length}) {
    const double spacing = end > 0.0 ? p.bridge_spacing : p.gum_spacing;
    require(3.0 * spacing + kBesideStrings <= outline_half_width(p, head_distance(p, end)),
            "guqin: bridge_spacing or gum_spacing too wide for the body");
  }
  // The sides must keep some height where the arch falls most.
  for (int k = 0; k <= 100; ++k) {
    const double s = p.length * k / 100.0;
    const double half_width = outline_half_width(p, s);
    const double side =
        crown_height(p, s) - arch_fall(1.0 / p.crown_radius, half_width) - lower_edge_height(p, s);
    require(half_width > 2.0 * p.edge + p.hollow, "guqin: edge or hollow too large for the width");
    require(side >= 2.0 * p.edge + kMinSide,
            "guqin: crown_radius or thickness too small for the width");
  }
}

}  // namespace hapticd
