// The Guqin's body as curves: outline, thickness and top over the distance s from the head's end
// (m). See guqin_model.h for parameters and frame. Internal to this folder. Offline.
#pragma once

#include "server/model/shapes/guqin_model.h"

namespace hapticd {

/// Throws std::invalid_argument naming the parameter unless all are in range and go together.
void check_guqin(const GuqinParameters& parameters);

/// s of a place with coordinate x in W, and back.
[[nodiscard]] double head_distance(const GuqinParameters& parameters, double x);
[[nodiscard]] double head_distance_to_x(const GuqinParameters& parameters, double s);

/// 0 below 0, 1 above 1, 3 t^2 - 2 t^3 between.
[[nodiscard]] double smooth_step(double t);

/// Half the width at s, plan corners included.
[[nodiscard]] double outline_half_width(const GuqinParameters& parameters, double s);
/// y of the crown line at s.
[[nodiscard]] double crown_height(const GuqinParameters& parameters, double s);
/// y of the lower edge at s.
[[nodiscard]] double lower_edge_height(const GuqinParameters& parameters, double s);

/// How far a circle of curvature k falls at the distance z from its top, |k z| < 1.
[[nodiscard]] double arch_fall(double curvature, double z);

/// A stretch of the outline that bends, between s = begin and end.
struct OutlineBend {
  double begin, end;
};
/// The four flanks of the indentations, in order.
[[nodiscard]] std::array<OutlineBend, 4> outline_bends(const GuqinParameters& parameters);

}  // namespace hapticd
