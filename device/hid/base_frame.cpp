// See base_frame.h. RT: yes.
#include "device/hid/base_frame.h"

namespace hapticd::hid {
namespace {

/// A pseudovector in D.
Array3 turned(const AxisMapping& map, double mirror, const Array3& raw) noexcept {
  const Array3 along = along_base(map, raw);
  return {mirror * along[0], mirror * along[1], mirror * along[2]};
}

bool same(const Array3& scale) noexcept { return scale[0] == scale[1] && scale[1] == scale[2]; }

DeviceSpring from_base(const AxisMapping& map, const DeviceSpring& spring_D) noexcept {
  DeviceSpring spring_R;
  const bool felt_as_told = map.force_sign == Array3{1.0, 1.0, 1.0};
  if (!felt_as_told || !same(map.position_scale) || !same(map.force_scale)) return spring_R;
  const double ratio = map.position_scale[0] / map.force_scale[0];
  // Places of xy, xz and yz by the sum of their axes.
  constexpr std::array<std::size_t, 4> kMixed{0, 3, 4, 5};
  for (std::size_t i = 0; i < 3; ++i) {
    spring_R.K_D[map.raw_axis[i]] = ratio * spring_D.K_D[i];
    spring_R.Kr_D[map.raw_axis[i]] = spring_D.Kr_D[i];
    for (std::size_t j = i + 1; j < 3; ++j) {
      const std::size_t raw = kMixed[static_cast<std::size_t>(map.raw_axis[i] + map.raw_axis[j])];
      spring_R.K_D[raw] = ratio * map.sign[i] * map.sign[j] * spring_D.K_D[kMixed[i + j]];
    }
  }
  return spring_R;
}

}  // namespace

void into_base(const AxisMapping& map, DeviceSample& sample) noexcept {
  const double mirror = handedness(map);
  sample.p_DH = position_in_base(map, sample.p_DH);
  sample.v_DH_D = position_in_base(map, sample.v_DH_D);
  sample.w_DH_D = turned(map, mirror, sample.w_DH_D);
  const Array4& q = sample.q_DH;
  const Array3 axis = turned(map, mirror, {q[1], q[2], q[3]});
  sample.q_DH = {q[0], axis[0], axis[1], axis[2]};
}

void from_base(const AxisMapping& map, DeviceCommand& command) noexcept {
  const double mirror = handedness(map);
  const Array3 t_D = command.t_H_D;
  command.spring = from_base(map, command.spring);
  command.f_H_D = raw_force(map, command.f_H_D);
  for (std::size_t i = 0; i < 3; ++i) {
    command.t_H_D[map.raw_axis[i]] = mirror * map.sign[i] * t_D[i];
  }
}

}  // namespace hapticd::hid
