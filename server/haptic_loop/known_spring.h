// The spring against which the handle rings while the damping of a device is measured: it takes the
// place of the rendered wrench, pulls the handle aside and lets it go, four times. Before the
// safety stage, so that every limit and fault holds. Frame: D of the device. RT: yes, about 10 ns.
#pragma once

#include "core/math/realtime.h"
#include "core/math/state_fields.h"
#include "core/math/vector.h"
#include "core/math/wrench.h"
#include "core/safety/passivity.h"
#include "core/tick/loop_state.h"
#include "core/tick/measuring_plan.h"
#include "core/tick/push_axis.h"

namespace hapticd {

/// Kept from tick to tick.
struct KnownSpring {
  PushAxis axis = 0;  ///< 0: nothing is measured
  double t_s = 0.0;   ///< since it began, [0, kMeasuring_s + kPushRamp_s)
  Array3 anchor{};    ///< p_DH where it began, m
  double owed = 0.0;  ///< what the hand had been given at the port before, J, >= 0
};

template <FieldsOf<KnownSpring> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [axis, t_s, anchor, owed] = state;
  visit.bounded(axis, 0, kPushAxes);
  visit(t_s, anchor, owed);
}

/// What a tick of the measuring depends on.
struct SpringTick {
  PushAxis asked = 0;  ///< begin along this axis; 0: go on
  LoopState state = LoopState::kDetached;
  bool clutch_open = false;  ///< ends it
  double dt_s = 0.0;
  Vector3 p_DH = Vector3::Zero();
};

/// One tick: as follow_push() does, begins what is asked for or goes on with what is under way. A
/// handle farther than kMaxExcursion from where it began ends it too: someone leads it. The energy
/// at the `port` starts anew with each ring; once it is over, what was given before counts again.
HD_REALTIME void follow_measuring(const SpringTick& tick, KnownSpring& spring,
                                  PortEnergy& port) noexcept;

/// How strong it is.
struct SpringStrength {
  double stiffness = 0.0;  ///< N/m
  double pull = 0.0;       ///< aside, at most, N
  double energy = 0.0;     ///< that it stores so, at most, J
};

/// What takes the place of `rendered`.
[[nodiscard]] HD_REALTIME Wrench with_spring(const KnownSpring& spring,
                                             const SpringStrength& strength, const Vector3& p_DH,
                                             const Wrench& rendered) noexcept;

}  // namespace hapticd
