// A direction in which a device is made to push by its guided check. Frame: D of the device. Plain
// data. RT: yes.
#pragma once

#include <cstdint>

namespace hapticd {

/// A direction of D with the number of hapticd::v1::Axis: +x -x +y -y +z -z; 0: none.
using PushAxis = std::uint8_t;
inline constexpr PushAxis kPushAxes = 6;

}  // namespace hapticd
