// What the loop tells the other threads, each thing exactly once: what was heard and touched,
// faults, and the ends of what it was told to do. Plain data through one ring. RT: yes.
#pragma once

#include <cstdint>
#include <type_traits>
#include <variant>

#include "core/safety/loop_state.h"
#include "core/simulation/touch_detector.h"
#include "core/tick/string_event.h"

namespace hapticd {

/// A fault was latched or cleared.
struct FaultNotice {
  Cause cause = Cause::kNone;
  bool latched = false;
};

/// From this tick on `scene_id` plays.
struct SceneSwapped {
  std::uint32_t scene_id = 0;
};

/// A change of settings is over, or overtaken.
struct SettingsRetired {
  std::uint64_t number = 0;  ///< of its LoopCommand
  bool dropped = false;      ///< it never began
};

/// A command that could not be obeyed in the state the loop is in.
struct CommandRefused {
  std::uint64_t number = 0;  ///< of the LoopCommand
  Cause cause = Cause::kNone;
};

/// A command that has been obeyed.
struct CommandDone {
  std::uint64_t number = 0;
};

struct LoopEvent {
  std::uint64_t tick = 0;
  std::int64_t t_ns = 0;  ///< of the tick; what is inside may have an instant of its own
  std::uint32_t scene_id = 0;
  std::uint32_t tool_id = 0;
  std::variant<std::monostate, StringEvent, TouchEvent, FaultNotice, SceneSwapped, SettingsRetired,
               CommandRefused, CommandDone>
      what;
};
static_assert(std::is_trivially_copyable_v<LoopEvent>);

}  // namespace hapticd
