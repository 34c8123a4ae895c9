// Saves the linearisation that would only confirm the last one. After a full step the forces of
// that program are put into the balance at the pose reached: what tool, strings and soft parts lack
// of equilibrium, over their stiffness, is the step that another program would want. RT: yes, about
// 0.3 us.
#pragma once

#include <optional>

#include "core/contact/contact_view.h"

namespace hapticd {

/// Share of the stop tolerance that the step still wanted may be: what the balance cannot see (the
/// least stiffness of the model is 0.02 of what it assumes only where a contact slips) has room.
/// Smaller: more linearisations; larger: less exact forces, by kt times the tolerance at most.
inline constexpr double kSettledShare = 0.1;

/// The wrench of the forces of the last program, which view.result names, at the pose reached, if
/// it balances tool and strings there; none else. `view`
/// is of that pose, strings and soft parts are built there, and its contacts are in the order of
/// the last program; `error_GH` is the error there.
[[nodiscard]] HD_REALTIME std::optional<Wrench> balanced_wrench(const ContactView& view,
                                                                const PoseError& error_GH) noexcept;

}  // namespace hapticd
