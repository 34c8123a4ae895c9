// Where the strings of the Guqin lie, from the model's parameters: what shipped scenes are held
// against. Frame W of guqin_model.h.
#pragma once

#include <array>
#include <cmath>

#include "server/model/shapes/guqin_model.h"
#include "server/model/shapes/guqin_outline.h"

namespace hapticd::test {

/// Frequencies of the strings, 1 to 7, Hz.
inline constexpr std::array<double, kGuqinStrings> kGuqinTuning{65.4,  73.4,  87.3, 98.0,
                                                                110.0, 130.8, 146.8};
/// One string at rest.
struct GuqinString {
  Vector3 p_WA{0.0, 0.0, 0.0};  ///< axis above the bridge's crest, m
  Vector3 p_WB{0.0, 0.0, 0.0};  ///< axis above the gum's crest, m
  double radius = 0.0;          ///< m
  double frequency = 0.0;       ///< Hz
};

/// Strings 1 to 7. Equal tension and material are assumed: the radius goes as 1 / frequency. They
/// keep `rest_gap` from bridge and gum, so that nothing touches at the start.
[[nodiscard]] inline std::array<GuqinString, kGuqinStrings> guqin_strings(
    const GuqinParameters& parameters) {
  check_guqin(parameters);
  const GuqinParameters& p = parameters;
  const auto rest = [&](double x, double z, double crest, double radius) {
    // The crest is inclined by the arch: the distance to it is measured along its normal.
    const double t = z / p.crown_radius;
    const double up = (radius + p.rest_gap) / std::sqrt(1.0 - t * t);
    return Vector3{x, guqin_top(p, x, z) + crest + up, z};
  };
  std::array<GuqinString, kGuqinStrings> strings;
  for (int i = 0; i < kGuqinStrings; ++i) {
    GuqinString& string = strings[static_cast<std::size_t>(i)];
    string.frequency = kGuqinTuning[static_cast<std::size_t>(i)];
    string.radius = p.string_radius * kGuqinTuning.back() / string.frequency;
    const double half_length = 0.5 * p.string_length;
    string.p_WA = rest(half_length, (i - 3) * p.bridge_spacing, p.bridge_height, string.radius);
    string.p_WB = rest(-half_length, (i - 3) * p.gum_spacing, p.gum_height, string.radius);
  }
  return strings;
}

}  // namespace hapticd::test
