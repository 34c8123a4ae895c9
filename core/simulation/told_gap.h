// The smallest gap of a tool to everything as all stands after a tick: tool, soft parts, and
// strings with the vertices of all tools. Beside the contact problem, whose own is of where it
// looked last. Frames: W. SI. RT: yes; a few pairs in touch, one more traversal where a tool moves
// near something.
#pragma once

#include <cstddef>

#include "core/simulation/string_players.h"

namespace hapticd {

/// Of tool number `tool` of `memory`, m: negative where it overlaps, at most its margin. All tools
/// have been rendered, and who holds which string is `sharing`. Uses the `swung` of the tool's
/// ToolPlay, which reach_out() fills afterwards.
[[nodiscard]] HD_REALTIME double told_gap(const SimulationMemory& memory,
                                          const StringSharing& sharing, std::size_t tool) noexcept;

/// The same of a tool that was not rendered and stands at `X_WG`. A whole traversal.
[[nodiscard]] HD_REALTIME double standing_gap(const SimulationMemory& memory,
                                              const StringSharing& sharing, std::size_t tool,
                                              const Pose& X_WG) noexcept;

}  // namespace hapticd
