// Whether a command is one at all. RT: yes.
#pragma once

#include <cmath>

#include "core/tick/device_sample.h"

namespace hapticd {

/// True when no component of wrench and spring is NaN or infinite.
[[nodiscard]] inline bool is_finite(const DeviceCommand& command) noexcept {
  for (const Array3& vector : {command.f_H_D, command.t_H_D})
    for (const double value : vector)
      if (!std::isfinite(value)) return false;
  for (const double value : command.spring.K_D)
    if (!std::isfinite(value)) return false;
  for (const double value : command.spring.Kr_D)
    if (!std::isfinite(value)) return false;
  return true;
}

}  // namespace hapticd
