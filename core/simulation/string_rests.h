// Strings that lie on things that do not move: frets, bridges, bars, boards. A string is taut: from
// one tool to the next, or to an end, it takes the shortest way over its rests. Those that it lies
// on are among its holders, and part it for the tools as other tools do (string_segments.h), so
// that a string pressed down behind a fret is as stiff, and sounds, as its part. Frames: W. SI. RT:
// yes, nothing where a scene has no rests, about 1 us per rest that a string lies on, of 200.
#pragma once

#include "core/simulation/string_segments.h"

namespace hapticd {

/// Lays the strings that tool number `tool` has just been rendered on over their rests, and forgets
/// those of strings that no tool holds any more. A tool that has gone over a rest to the next part
/// holds that one. `before`: the tool's state before it was rendered. To be called after
/// update_sharing(). False where a string lies on others than the tool was rendered with.
HD_REALTIME bool settle_rests(std::span<const StringTool> tools, std::int32_t tool,
                              const ToolState& before, StringSharing& holders) noexcept;

/// Adds to `tick` what a tool presses on strings right beside a rest: that is borne by the rest,
/// and the contact problem has it as of a rigid line. To be called after update_sharing().
HD_REALTIME void add_rest_forces(const StringTool& self, const ContactInput& input,
                                 RenderedTool& tick) noexcept;

}  // namespace hapticd
