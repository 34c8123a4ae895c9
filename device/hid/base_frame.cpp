// See base_frame.h. RT: yes.
#include "device/hid/base_frame.h"

namespace hapticd::hid {
namespace {

/// A pseudovector in D.
Array3 turned(const AxisMapping& map, double mirror, const Array3& raw) noexcept {
  const Array3 along = along_base(map, raw);
  return {mirror * along[0], mirror * along[1], mirror * along[2]};
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
  command.f_H_D = raw_force(map, command.f_H_D);
  for (std::size_t i = 0; i < 3; ++i) {
    command.t_H_D[map.raw_axis[i]] = mirror * map.sign[i] * t_D[i];
  }
}

}  // namespace hapticd::hid
