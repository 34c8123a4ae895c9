// Samples and commands of a HID device between its own axes R, as the maker laid them, and the base
// frame D, by the axis map of its profile. With M the choice of axes and signs, and m = det M:
//   p_D = s M p_R      v_D = s M v_R      R_DH = M R_RH M^T, the rotation vector m M r
//   w_D = m M w_R      f_R = M^T (sign f_D / scale)          t_R = m M^T t_D
// so a left-handed choice mirrors rotations and torques, which are pseudovectors, and with scales
// and signs of 1 the power f . v + t . w is the same in both frames. rotation_scale and dead_zone
// are for other devices: reports of profile v1 come in radians. SI. RT: yes, 40 multiplications; a
// map that leaves readings as they are leaves each bit of them.
#pragma once

#include "core/math/realtime.h"
#include "device/api/axis_mapping.h"
#include "device/api/device_sample.h"

namespace hapticd::hid {

/// Pose and velocities of `sample`, measured in R, become those in D.
HD_REALTIME void into_base(const AxisMapping& map, DeviceSample& sample) noexcept;

/// Force and torque of `command`, in D, become what to tell the device, in R.
HD_REALTIME void from_base(const AxisMapping& map, DeviceCommand& command) noexcept;

}  // namespace hapticd::hid
