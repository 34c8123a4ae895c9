// See implicit_shape.h.
#include "server/model/shapes/implicit_shape.h"

#include <algorithm>
#include <cmath>

namespace hapticd {

double distance(const RoundCone& cone, const Vector3& p) noexcept {
  const Vector3 axis = cone.p_b - cone.p_a;
  const Vector3 from_a = p - cone.p_a;
  const Vector3 from_b = p - cone.p_b;
  const double height = length(axis);
  const double taper = cone.r_a - cone.r_b;
  if (height <= std::fabs(taper)) {
    return taper >= 0.0 ? length(from_a) - cone.r_a : length(from_b) - cone.r_b;
  }
  // In the plane of axis and point: the line that touches both circles has the normal (cosine
  // across, sine along the axis).
  const double along = dot(from_a, axis) / height;
  const double across = std::sqrt(std::max(0.0, dot(from_a, from_a) - along * along));
  const double sine = taper / height;
  const double cosine = std::sqrt(1.0 - sine * sine);
  const double foot = along * cosine - across * sine;
  if (foot < 0.0) return length(from_a) - cone.r_a;
  if (foot > height * cosine) return length(from_b) - cone.r_b;
  return across * cosine + along * sine - cone.r_a;
}

double smooth_minimum(double a, double b, double blend) noexcept {
  const double overlap = std::max(0.0, blend - std::fabs(a - b)) / blend;
  return std::min(a, b) - 0.25 * blend * overlap * overlap;
}

}  // namespace hapticd
