// Where a replayed tick differs from the recorded one. Not RT.
#pragma once

#include <string>

#include "server/haptic_loop/tick_trace.h"

namespace hapticd {

/// The first of what the tick gave that differs in any bit, such as "wrench_h_w of tool 0": names
/// are those of TickRecord. Empty: all is the same. Time spent is not compared. 100 ns.
[[nodiscard]] std::string tick_difference(const TickTrace& recorded, const TickTrace& replayed);

}  // namespace hapticd
