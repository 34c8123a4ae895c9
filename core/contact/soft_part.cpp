// See soft_part.h. RT: yes.
#include "core/contact/soft_part.h"

namespace hapticd {

std::optional<ParameterFault> check_part(const ToolPart& part) noexcept {
  constexpr ParameterRange kStiffness{1.0, 1e9, true, "[1, 1e9]"};
  constexpr ParameterRange kDamping{0.0, 1e6, true, "[0, 1e6]"};
  if (part.stiffness != 0.0 && !contains(kStiffness, part.stiffness)) {
    return ParameterFault{"fingertip.stiffness_n_per_m", part.stiffness, kStiffness.text,
                          "Give the stiffness of the fingertip, or leave it out: rigid."};
  }
  if (!contains(kDamping, part.damping)) {
    return ParameterFault{"fingertip.damping_n_s_per_m", part.damping, kDamping.text,
                          "Give the damping of the fingertip; 0 is none."};
  }
  return std::nullopt;
}

}  // namespace hapticd
