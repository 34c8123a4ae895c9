// Recovery from a penetrated start (a scene edited onto the tool, a start inside an obstacle):
// pushes G out by translation along the normals of the deepest contacts, never faster than
// OptimiserOptions::recovery_speed, accepting only steps that enlarge the minimum gap and close
// none that is open. RT: yes.
#pragma once

#include "core/contact/configuration_optimiser.h"

namespace hapticd {

/// One push-out step over input.dt. Precondition: start_tick found a negative minimum gap. Leaves G
/// where it is when no direction enlarges the gap. The force of the tick is the coupling's spring
/// force; the caller limits it.
HD_REALTIME void recover(const OptimiserInput& input, OptimiserState& state,
                         OptimiserWorkspace& workspace, OptimiserResult& result) noexcept;

}  // namespace hapticd
