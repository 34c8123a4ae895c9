// Velocities of devices that measure positions alone: the difference of successive samples over
// their true distance in time. No filter: what quantisation makes of it is for the reader to know.
// Frame D. SI. RT: yes, about 100 ns.
#pragma once

#include "core/math/realtime.h"
#include "core/tick/device_sample.h"

namespace hapticd {

/// Fills v_DH_D and w_DH_D of `sample` from `last`, the sample before it: zero when no time has
/// passed between them, or when a pose is not finite. has_velocity is left as it is.
HD_REALTIME void difference_velocity(const DeviceSample& last, DeviceSample& sample) noexcept;

}  // namespace hapticd
