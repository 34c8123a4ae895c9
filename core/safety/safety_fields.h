// The fields of what the safety stage and the loop's state machine keep from tick to tick, for
// snapshots and replay (core/math/state_fields.h). RT: yes.
#pragma once

#include "core/math/state_fields.h"
#include "core/safety/loop_state.h"
#include "core/safety/output_stage.h"
#include "core/safety/overrun_watch.h"
#include "core/safety/pose_guard.h"

namespace hapticd {

HD_VISIT_FIELDS(WrenchFlight, f_H_D, t_H_D, given)
HD_VISIT_FIELDS(PortEnergy, given, removed, share, flight)

template <FieldsOf<ThermalLoad> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [blocks, current, current_s, oldest] = state;
  visit(blocks, current, current_s);
  visit.bounded(oldest, 0, kThermalBlocks - 1);
}

HD_VISIT_FIELDS(SafetyState, f_H_D, t_H_D, port, force_load, torque_load)
HD_VISIT_FIELDS(PoseGuard, X_DH, V_DH_D, t_ns, counter, has_pose, missed_ticks, bad_ticks,
                still_since_ns, bad_total, fast_total, held_total)
HD_VISIT_FIELDS(OverrunWatch, late_ns, total)

template <FieldsOf<LoopMachine> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [loop_state, cause, gain, wanted, started, ending] = state;
  visit.bounded(loop_state, 1, static_cast<int>(LoopState::kOver));
  visit.bounded(cause, 0, kMaxCause);
  visit(gain, wanted, started, ending);
}

}  // namespace hapticd
