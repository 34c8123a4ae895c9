// Saves the linearisation that would only confirm the last one. After a full step the forces of
// that program are put into the balance at the pose reached: what tool, strings and soft parts lack
// of equilibrium, over their stiffness, is the step that another program would want. RT: yes, about
// 0.3 us.
#pragma once

#include "core/contact/contact_problem.h"

namespace hapticd {

/// Share of the stop tolerance that the step still wanted may be: what the balance cannot see (the
/// least stiffness of the model is 0.02 of what it assumes only where a contact slips) has room.
/// Smaller: more linearisations; larger: less exact forces, by kt times the tolerance at most.
inline constexpr double kSettledShare = 0.1;

/// True when the forces of the last program, which state.active names, balance tool and strings at
/// the pose reached: `F_H_W` then is their wrench there. `e` is the error there; the contacts of
/// `w` must have been evaluated there, in the order of the last program. Never with friction or
/// lateral force.
[[nodiscard]] HD_REALTIME bool is_stationary(const ContactInput& input, const ContactState& state,
                                             const PoseError& error_GH, OptimiserWorkspace& w,
                                             const ContactResult& result, Wrench& F_H_W) noexcept;

}  // namespace hapticd
