// Whose touch the events of a string are, and where on the tool. Frames: W. SI. RT: yes, one look
// at the pairs of the tool for a string that has events, else none.
#pragma once

#include "core/simulation/string_proximity.h"

namespace hapticd {

/// Whose touch the events of a string are in a tick.
struct Toucher {
  const ToolPlay& play;
  std::int32_t tool;
  std::int32_t string;
  TickTime time;
  const ToolStringState& seen;
};

/// Says of the events from number `first` on, all of the toucher's string, whose touch they are.
/// Where it is: where the tool is nearest to the string, or, where it is not near any more, where
/// it was last, at the same place of the tool. A touch that was let go of in an earlier tick, and
/// ends now, was where it was after that tick.
HD_REALTIME void name_place(std::size_t first, const Toucher& toucher,
                            StringEvents& events) noexcept;

/// What the next tick has to know of `near`, in which time has passed, and of the place as
/// name_place has it. `touched_ns`: when the tool touched the string last. `seen` is the toucher's.
HD_REALTIME void remember(const Toucher& toucher, const StringProximity& near,
                          std::int64_t touched_ns, ToolStringState& seen) noexcept;

}  // namespace hapticd
