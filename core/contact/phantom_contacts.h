// Pairs that the last program of a tick lets bear force although the tool has not come to them: one
// that runs out of linearisations on a long way solves for where it wants to go, and stops before.
// They are no contacts of the tick. RT: yes; nothing where the tick has converged.
#pragma once

#include <span>

#include "core/contact/contact_view.h"

namespace hapticd {

/// What came before the last step of a tick.
struct BeforeStep {
  Vector3 p_WG;  ///< where the last program was solved, m
  /// Pairs that bore force when the tick began.
  std::span<const ContactKey> pressed;
};

/// Takes the pairs of the last program out of result and state that are farther than a touch from
/// the tool as it stands, did not bear force before the tick, and which the hand does not touch
/// either; with them their forces, and what clings to a string left without any. `view`: of the
/// problem whose result and state these are.
HD_REALTIME void drop_phantoms(const ContactView& view, const BeforeStep& before,
                               ContactState& state, ContactResult& result) noexcept;

}  // namespace hapticd
