// What the loop is told by the other threads: a few plain commands per tick, obeyed at its edge.
// Scenes, gestures and changes of settings are prepared before, and go to the loop through a ring
// of their own, each before its command (LoopChannels). RT: yes, plain data.
#pragma once

#include <cstdint>
#include <type_traits>
#include <variant>

#include "core/math/vector.h"
#include "core/tick/push_axis.h"

namespace hapticd {

/// Force on: from a contact-free start.
struct EngageCommand {};
/// Force off: 50 ms ramp.
struct DisengageCommand {};
/// Zero wrench at once, latched.
struct StopCommand {};
/// Leaves a latched fault whose cause is gone.
struct ClearCommand {};
/// The lease of whoever gave the poses is over. Poses that wait, and changes of settings for a tick
/// to come, go with it.
struct LeaseLostCommand {
  std::uint64_t ended = 0;  ///< leases that have ended: poses of an earlier number are forgotten
};
/// The daemon ends: force ramps to zero, then the loop stays over.
struct EndCommand {};
/// The next scene lent takes the place of the one that plays, once the force is zero.
struct SwapSceneCommand {};
/// The device's present pose becomes the tool's home.
struct RecentreCommand {
  std::uint32_t tool = 0;  ///< in the scene's order
};
/// Lets go of the tool while the device moves on, or takes hold of it again.
struct ClutchCommand {
  std::uint32_t tool = 0;  ///< in the scene's order
  bool open = false;
};

/// Pushes a tool's device for the guided check; refused unless force is on.
struct PushCommand {
  std::uint32_t tool = 0;  ///< in the scene's order
  PushAxis axis = 0;       ///< [1, kPushAxes]
};

/// Measures the damping of a tool's device along an axis; refused unless force is on.
struct MeasureCommand {
  std::uint32_t tool = 0;  ///< in the scene's order
  PushAxis axis = 0;       ///< [1, kPushAxes]
};

/// The simulated hands play the next gesture lent; refused when no device is one.
struct PlayGestureCommand {};

/// Live settings change as the next change lent says.
struct ChangeSettingsCommand {};

/// Work that every tick from the next on is allowed, as BudgetTick's.
struct WorkBudgetCommand {
  std::int64_t work = 0;  ///< 0: no bound
};

/// What is to be done.
using LoopCommandBody = std::variant<std::monostate, EngageCommand, DisengageCommand, StopCommand,
                                     ClearCommand, LeaseLostCommand, EndCommand, SwapSceneCommand,
                                     RecentreCommand, ClutchCommand, PushCommand, MeasureCommand,
                                     PlayGestureCommand, ChangeSettingsCommand, WorkBudgetCommand>;

struct LoopCommand {
  std::uint64_t number = 0;  ///< chosen by the sender, comes back in CommandDone or CommandRefused
  LoopCommandBody what;
};
static_assert(std::is_trivially_copyable_v<LoopCommand>);

}  // namespace hapticd
