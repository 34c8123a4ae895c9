// What hands feel of a string that sounds beyond its static law, as its tank lets them. Frames: W.
// SI. RT: yes, 0.1 us per tool.
#pragma once

#include "core/simulation/wave_meeting.h"

namespace hapticd {

/// Books the tick, and adds to the wrench of each tool.
HD_REALTIME void give_forces(const Playing& playing, const NearTools& tools,
                             const Touches& touches) noexcept;

/// A tick in which no time passes: what was held is.
HD_REALTIME void hold_forces(const Playing& playing, const NearTools& tools,
                             const Touches& touches) noexcept;

}  // namespace hapticd
