// From the raw readings of a device to its base frame D, and forces back: which raw axis becomes x,
// y and z of D, with which sign and scale. A left-handed choice mirrors rotations too, which are
// pseudovectors. Frames: raw, the device's own; D (x right, y up, z toward the user). Plain data.
// RT: yes, a few multiplications.
#pragma once

#include <cstdint>
#include <type_traits>

#include "core/math/realtime.h"
#include "core/math/vector.h"

namespace hapticd {

/// How the axes of a device lie. The defaults leave readings as they are.
struct AxisMapping {
  std::array<std::uint8_t, 3> raw_axis{0, 1, 2};  ///< that becomes x, y, z of D; each once
  Array3 sign{1.0, 1.0, 1.0};                     ///< of that axis, 1 or -1
  Array3 position_scale{1.0, 1.0, 1.0};  ///< m per raw unit, rate devices m/s; per axis of D
  Array3 rotation_scale{1.0, 1.0, 1.0};  ///< rad per raw unit, rate devices rad/s; per axis of D
  Array3 force_scale{1.0, 1.0, 1.0};     ///< N per raw unit of force; per axis of D
  Array3 force_sign{1.0, 1.0, 1.0};      ///< of the force felt at +1 N; 1 or -1, axes of D
  double dead_zone = 0.0;                ///< readings of at most this count as zero, raw units
};
static_assert(std::is_trivially_copyable_v<AxisMapping>);

/// `raw` along the axes of D, with signs, unscaled.
[[nodiscard]] HD_REALTIME inline Array3 along_base(const AxisMapping& map,
                                                   const Array3& raw) noexcept {
  return {map.sign[0] * raw[map.raw_axis[0]], map.sign[1] * raw[map.raw_axis[1]],
          map.sign[2] * raw[map.raw_axis[2]]};
}

/// 1 for a right-handed choice of axes, -1 for one that mirrors.
[[nodiscard]] HD_REALTIME inline double handedness(const AxisMapping& map) noexcept {
  const bool cyclic = (map.raw_axis[0] + 1) % 3 == map.raw_axis[1];
  return (cyclic ? 1.0 : -1.0) * map.sign[0] * map.sign[1] * map.sign[2];
}

/// Position, or its rate, in D. m, or m/s.
[[nodiscard]] HD_REALTIME inline Array3 position_in_base(const AxisMapping& map,
                                                         const Array3& raw) noexcept {
  const Array3 turned = along_base(map, raw);
  return {map.position_scale[0] * turned[0], map.position_scale[1] * turned[1],
          map.position_scale[2] * turned[2]};
}

/// Rotation vector, or its rate, in D. rad, or rad/s.
[[nodiscard]] HD_REALTIME inline Array3 rotation_in_base(const AxisMapping& map,
                                                         const Array3& raw) noexcept {
  const Array3 turned = along_base(map, raw);
  const double mirror = handedness(map);
  return {mirror * map.rotation_scale[0] * turned[0], mirror * map.rotation_scale[1] * turned[1],
          mirror * map.rotation_scale[2] * turned[2]};
}

/// What to send to the device, in its raw axes and units, so that the hand feels `f_D`, N.
[[nodiscard]] HD_REALTIME inline Array3 raw_force(const AxisMapping& map,
                                                  const Array3& f_D) noexcept {
  Array3 raw{};
  for (std::size_t i = 0; i < 3; ++i) {
    raw[map.raw_axis[i]] = map.sign[i] * map.force_sign[i] * f_D[i] / map.force_scale[i];
  }
  return raw;
}

}  // namespace hapticd
