// Recovery from a penetrated start (a scene edited onto the tool, a start inside an obstacle):
// pushes G out by translation along the normals of the deepest contacts, never faster than
// ContactOptions::recovery_speed, accepting only steps that enlarge the minimum gap and close
// none that is open. RT: yes.
#pragma once

#include "core/contact/contact_problem.h"

namespace hapticd {

/// One push-out step over input.dt. Precondition: start_tick found a negative minimum gap. Leaves G
/// where it is when no direction enlarges the gap. The force of the tick is the coupling's spring
/// force; the caller limits it.
HD_REALTIME void recover(const ContactInput& input, ContactState& state,
                         OptimiserWorkspace& workspace, ContactResult& result) noexcept;

}  // namespace hapticd
