// A spring about a pose of a device's handle, in plain numbers: f = K (p_ref - p), t = Kr e with e
// the rotation back to that pose. Frame: D, the device's base. RT: yes, plain data.
#pragma once

#include <array>
#include <type_traits>

#include "core/math/vector.h"

namespace hapticd {

/// All zero: none.
struct DeviceSpring {
  std::array<double, 6> K_D{};  ///< symmetric, positive semidefinite: xx, yy, zz, xy, xz, yz, N/m
  Array3 Kr_D{};                ///< about each axis, N m/rad, >= 0
};
static_assert(std::is_trivially_copyable_v<DeviceSpring>);

[[nodiscard]] inline bool is_none(const DeviceSpring& spring) noexcept {
  return spring.K_D == std::array<double, 6>{} && spring.Kr_D == Array3{};
}

}  // namespace hapticd
