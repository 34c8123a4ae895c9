// The vertices of all strings as they stand after a tick, for those who draw them: a string goes
// straight from its end A through them to B. Frames: W. SI. RT: yes, about 10 ns per vertex.
#pragma once

#include "core/simulation/string_players.h"

namespace hapticd {

/// Fills tick.string_bends once all tools of `memory` have been rendered; who holds which string is
/// `sharing`.
HD_REALTIME void tell_bends(const SimulationMemory& memory, const StringSharing& sharing,
                            Tick& tick) noexcept;

}  // namespace hapticd
