// The axes of the SpaceMouse family, as its sources name them (spacemouse_report.h).
#pragma once

#include "device/api/axis_mapping.h"

namespace hapticd::test {

/// Axes at the speeds given at full deflection, m/s and rad/s: x of D is raw x, y is up and so raw
/// -z, z is raw y.
[[nodiscard]] inline AxisMapping family_axes(double full_speed, double full_turn) {
  constexpr double kFullDeflection = 350.0;
  const double position = full_speed / kFullDeflection;
  const double rotation = full_turn / kFullDeflection;
  AxisMapping axes;
  axes.raw_axis = {0, 2, 1};
  axes.sign = {1.0, -1.0, 1.0};
  axes.position_scale = {position, position, position};
  axes.rotation_scale = {rotation, rotation, rotation};
  return axes;
}

}  // namespace hapticd::test
