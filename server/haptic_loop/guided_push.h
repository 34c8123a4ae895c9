// The push of the guided check: for a second a tool's rendered wrench gives way to a small force
// along one axis of the device, so that a person can say where it was felt. A trapezoid over the
// time of ticks, before the safety stage, so that every limit and fault holds; afterwards the
// rendered wrench comes back by a ramp. Frame: D of the device. RT: yes, about 5 ns.
#pragma once

#include "core/math/realtime.h"
#include "core/math/state_fields.h"
#include "core/math/wrench.h"
#include "core/safety/loop_state.h"
#include "core/tick/push_axis.h"

namespace hapticd {

/// Force of a push, N. Larger: a wrong sign can hurt; smaller: friction hides it.
inline constexpr double kPushForce = 0.3;
/// Ramps of a push, and of the rendered wrench when it comes back, s. Shorter: felt as a blow.
inline constexpr double kPushRamp_s = 0.2;
/// A whole push, ramps included, s.
inline constexpr double kPush_s = 1.0;

/// Kept from tick to tick.
struct GuidedPush {
  PushAxis axis = 0;  ///< 0: no push is under way
  double t_s = 0.0;   ///< since it began, [0, kPush_s + kPushRamp_s)
};

template <FieldsOf<GuidedPush> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [axis, t_s] = state;
  visit.bounded(axis, 0, kPushAxes);
  visit(t_s);
}

/// One tick: begins the push that is `asked` for, or goes on with the one under way. It needs a
/// loop that is engaged, stands still while force is released, so that it fades with the gain, and
/// ends in any other state. True where it begins and where it is over, both without a force: the
/// energy at the port starts anew there, since a hand that gives way is never given back what a
/// push spends on it, and would feel the next ones less and less.
[[nodiscard]] HD_REALTIME bool follow_push(PushAxis asked, LoopState state, double dt_s,
                                           GuidedPush& push) noexcept;

/// What takes the place of `rendered`.
[[nodiscard]] HD_REALTIME Wrench with_push(const GuidedPush& push, const Wrench& rendered) noexcept;

}  // namespace hapticd
