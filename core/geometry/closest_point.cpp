// The fallback normal of a centre that lies on the axis. See closest_point.h. RT: yes.
#include "core/geometry/closest_point.h"

namespace hapticd {

// The part normal to the axis of the coordinate axis it is least aligned with; ties prefer y (a
// string along x is left upwards), then z.
Vector3 fixed_normal(const Vector3& axis) noexcept {
  const double axis_length = length(axis);
  if (axis_length < kMinLength) return {0.0, 1.0, 0.0};
  const Vector3 direction = axis / axis_length;
  const Vector3 alignment = direction.cwiseAbs();
  Vector3 least_aligned{0.0, 1.0, 0.0};
  double component = alignment.y();
  if (alignment.z() < component) {
    least_aligned = {0.0, 0.0, 1.0};
    component = alignment.z();
  }
  if (alignment.x() < component) {
    least_aligned = {1.0, 0.0, 0.0};
  }
  const double along = least_aligned.dot(direction);
  const Vector3 normal = least_aligned - along * direction;
  return normal / length(normal);
}

}  // namespace hapticd
