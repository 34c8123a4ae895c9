// What one tick of a simulation is computed from, and what it gives. Frames: W. SI. RT: yes, plain
// data.
#pragma once

#include <array>
#include <cstdint>

#include "core/simulation/tool_renderer.h"
#include "core/tick/string_event.h"
#include "core/tick/string_tick.h"

namespace hapticd {

/// What one tick is computed from: a pose per tool, in the order of the tools; further ones are not
/// looked at.
struct TickInput {
  std::array<HandPose, kMaxTools> hands;
  /// Work of all tools together (core/contact/tick_work.h), chosen before the tick, >= 0; what a
  /// tool leaves of its share is for those after it. 0: no bound.
  std::int64_t work_budget = 0;
};

/// The input of a simulation of one tool.
[[nodiscard]] inline TickInput input_of(const HandPose& hand) noexcept {
  TickInput input;
  input.hands[0] = hand;
  return input;
}

/// What one tick gives.
struct TickOutput {
  FixedVector<RenderedTool, kMaxTools> tools;
  StringEvents events;
  FixedVector<StringTick, kMaxStrings> strings;
};

}  // namespace hapticd
