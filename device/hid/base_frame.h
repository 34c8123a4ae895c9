// Samples and commands of a HID device between its own axes R, as the maker laid them, and the base
// frame D, by the axis map of its profile. With M the choice of axes and signs, and m = det M:
//   p_D = s M p_R      v_D = s M v_R      R_DH = M R_RH M^T, the rotation vector m M r
//   w_D = m M w_R      f_R = M^T (sign f_D / scale)          t_R = m M^T t_D
//   K_R = s M^T K_D M / scale, where each of both scales is the same for all axes
// so a left-handed choice mirrors rotations and torques, which are pseudovectors, and with scales
// and signs of 1 the power f . v + t . w is the same in both frames. rotation_scale and dead_zone
// are for other devices: reports of profile v1 come in radians. SI. RT: yes, 40 multiplications; a
// map that leaves readings as they are leaves each bit of them.
#pragma once

#include "core/math/realtime.h"
#include "core/tick/device_sample.h"
#include "device/api/axis_mapping.h"

namespace hapticd::hid {

/// Pose and velocities of `sample`, measured in R, become those in D.
HD_REALTIME void into_base(const AxisMapping& map, DeviceSample& sample) noexcept;

/// Force, torque and spring of `command`, in D, become what to send to the device, in R. No spring
/// is left where scales differ from axis to axis, so that no symmetric K_R does the same, or where
/// a force is felt against its sign, which would make the device's own spring push away.
HD_REALTIME void from_base(const AxisMapping& map, DeviceCommand& command) noexcept;

}  // namespace hapticd::hid
