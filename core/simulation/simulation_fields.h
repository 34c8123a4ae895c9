// The fields of what a simulation keeps from tick to tick, and of its settings, for snapshots and
// replay (core/math/state_fields.h). RT: yes.
#pragma once

#include "core/instrument/string_fields.h"
#include "core/math/state_fields.h"
#include "core/simulation/live_settings.h"
#include "core/simulation/simulation.h"
#include "core/simulation/tool_fields.h"
#include "core/simulation/touch_detector.h"

namespace hapticd {

template <FieldsOf<PlayedString> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [string, player, place] = state;
  visit(string, player, place);
}

template <FieldsOf<SharedString> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [string, tools] = state;
  visit(string, tools);
}

template <FieldsOf<Capsule> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [p_A, p_B, r] = state;
  visit(p_A, p_B, r);
}

template <FieldsOf<StringPart> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [string, slot, part_W, lambda_from, lambda_to] = state;
  visit(string, slot, part_W, lambda_from, lambda_to);
}

/// Only the parts go from tick to tick: the rest is made from them and the scene.
template <FieldsOf<StringSegments> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [capsules_W, groups, strings, parts, rigid, rigid_active] = state;
  static_cast<void>(capsules_W);
  static_cast<void>(groups);
  static_cast<void>(strings);
  static_cast<void>(rigid);
  static_cast<void>(rigid_active);
  visit(parts);
}

template <FieldsOf<ToolStringState> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [distance, u_W, v_W, nhat_W, p_GC_W, part, detector] = state;
  visit(distance, u_W, v_W, nhat_W, p_GC_W, part, detector);
}

template <FieldsOf<TouchEvent> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [t_ns, begins, part, kind, obstacle, lambda, p_WC, nhat_OG_W, normal_speed,
         tangential_speed, force] = state;
  visit(t_ns, begins, part);
  visit.bounded(kind, 0, kMaxObstacleKind);
  visit(obstacle, lambda, p_WC, nhat_OG_W, normal_speed, tangential_speed, force);
}

template <FieldsOf<TouchDetector> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [touches] = state;
  visit(touches);
}

template <FieldsOf<LiveSettings> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [coupling, coupling_damping, force_gain, scale, X_WD, contact, instrument, quality_level,
         quality_automatic] = state;
  visit(coupling, coupling_damping, force_gain, scale, X_WD, contact, instrument, quality_level,
        quality_automatic);
}

}  // namespace hapticd
