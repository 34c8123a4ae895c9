// Whose touch the events of a string are, and where on the tool. Frames: W. SI. RT: yes, one look
// at the pairs of the tool for a string that has events, else none.
#pragma once

#include "core/simulation/string_proximity.h"

namespace hapticd {

/// Whose touch a string's events are.
struct Toucher {
  const ToolPlay& play;
  std::int32_t tool;
  const ToolStringState& seen;
};

/// Says of the events of `string` from number `first` on whose touch they are. Where it is: where
/// the tool is nearest to the string, or, where it is not near any more, where it was last, at the
/// same place of the tool.
HD_REALTIME void name_place(std::size_t first, const Toucher& toucher, std::int32_t string,
                            StringEvents& events) noexcept;

/// What the next tick has to know of `near`, in which time has passed, and of the place as
/// name_place has it; `seen` is the toucher's.
HD_REALTIME void remember(const Toucher& toucher, std::int32_t string, const StringProximity& near,
                          ToolStringState& seen) noexcept;

}  // namespace hapticd
