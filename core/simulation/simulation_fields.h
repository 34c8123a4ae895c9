// The fields of what a simulation keeps from tick to tick, and of its settings, for snapshots and
// replay (core/math/state_fields.h). RT: yes.
#pragma once

#include "core/instrument/string_fields.h"
#include "core/math/state_fields.h"
#include "core/rendering/tool_fields.h"
#include "core/simulation/live_settings.h"
#include "core/simulation/simulation.h"
#include "core/simulation/touch_detector.h"

namespace hapticd {

template <FieldsOf<StringTrack> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [string, player] = state;
  visit(string, player);
}

template <FieldsOf<StringVisit> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [distance, u_W, v_W, nhat_W, p_GC_W, detector] = state;
  visit(distance, u_W, v_W, nhat_W, p_GC_W, detector);
}

template <FieldsOf<TouchEvent> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [t_ns, begins, part, kind, obstacle, lambda, p_WC, nhat_OG_W, normal_speed,
         tangential_speed, force] = state;
  visit(t_ns, begins, part);
  visit.bounded(kind, 0, static_cast<int>(ObstacleKind::kBody));
  visit(obstacle, lambda, p_WC, nhat_OG_W, normal_speed, tangential_speed, force);
}

template <FieldsOf<TouchDetector> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [touches] = state;
  visit(touches);
}

template <FieldsOf<LiveSettings> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [coupling, coupling_damping, force_gain, scale, X_WD, optimiser, instrument, quality_level,
         quality_automatic] = state;
  visit(coupling, coupling_damping, force_gain, scale, X_WD, optimiser, instrument, quality_level,
        quality_automatic);
}

}  // namespace hapticd
