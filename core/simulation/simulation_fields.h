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

HD_VISIT_FIELDS(PlayedString, string, player, place)
HD_VISIT_FIELDS(SharedString, string, holders)
HD_VISIT_FIELDS(Capsule, p_A, p_B, r)
HD_VISIT_FIELDS(StringPart, string, slot, part_W, lambda_from, lambda_to)

/// Only the parts go from tick to tick: the rest is made from them and the scene.
template <FieldsOf<StringSegments> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [capsules_W, groups, strings, parts, rigid, rigid_active] = state;
  visit(parts);
}

HD_VISIT_FIELDS(ToolStringState, distance, u_W, v_W, nhat_W, p_GC_W, told_nhat_W, left_p_WC,
                left_nhat_W, left_part, part, detector)

template <FieldsOf<TouchEvent> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [t_ns, begins, part, kind, obstacle, lambda, p_WC, nhat_OG_W, normal_speed,
         tangential_speed, force] = state;
  visit(t_ns, begins, part);
  visit.bounded(kind, 0, kMaxObstacleKind);
  visit(obstacle, lambda, p_WC, nhat_OG_W, normal_speed, tangential_speed, force);
}

HD_VISIT_FIELDS(TouchDetector, touches)
HD_VISIT_FIELDS(LiveSettings, coupling, coupling_damping, force_gain, scale, X_WD, contact,
                instrument, quality_level, quality_automatic)

}  // namespace hapticd
