// The fields of what a tool keeps from tick to tick, for snapshots and replay
// (core/math/state_fields.h). Indices that are read back must also fit the scene: fits_scene(). RT:
// yes.
#pragma once

#include <cmath>
#include <type_traits>

#include "core/math/state_fields.h"
#include "core/simulation/tool_renderer.h"
#include "core/simulation/workspace_map.h"

namespace hapticd {

HD_VISIT_FIELDS(HandMotion, X_WH, V_WH, t_ns, has_pose)

template <FieldsOf<ContactKey> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [kind, obstacle, tool_sphere, obstacle_sphere] = state;
  visit.bounded(kind, 0, kMaxObstacleKind);
  visit(obstacle, tool_sphere, obstacle_sphere);
}

HD_VISIT_FIELDS(ActivePair, key, multiplier)
HD_VISIT_FIELDS(StringBend, capsule, lambda, u_W)
HD_VISIT_FIELDS(TouchedString, bend, u_felt_W, yields, normal_force, tangential_W, slip_W)
HD_VISIT_FIELDS(SoftPart, part, v_G, v_before_G)

template <FieldsOf<Grip> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [kind, obstacle, normal_force, slip_W] = state;
  visit.bounded(kind, 0, kMaxObstacleKind);
  visit(obstacle, normal_force, slip_W);
}

// Pairs beyond the count mean nothing.
template <FieldsOf<ContactState> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [X_WG, phi_GH_W, F_H_W, active_count, active, touched, parts, grips, tool_level, body_level,
         X_WH, travel, clearance] = state;
  visit(X_WG, phi_GH_W, F_H_W);
  visit.bounded(active_count, 0, kMaxQpUnknowns);
  visit.first(active, active_count);
  visit(touched, parts, grips);
  visit.bounded(tool_level, 0, std::numeric_limits<int>::max());
  visit.bounded(body_level, 0, std::numeric_limits<int>::max());
  visit(X_WH, travel, clearance);
}

HD_VISIT_FIELDS(ToolState, hand, contact, placed, force_bound)
HD_VISIT_FIELDS(WorkspaceState, c_W, q_off, p_held_W, q_held, wrench_share, open, recentre_was_down)
HD_VISIT_FIELDS(AxisShares, along_W, about_G)

// A negative length says that the shares follow.
template <FieldsOf<CouplingStiffness> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [kt, length, per_axis, shares] = state;
  double told = per_axis ? -length : length;
  visit(kt, told);
  if constexpr (!std::is_const_v<State>) {
    per_axis = told < 0.0;
    length = std::abs(told);
  }
  if (per_axis) visit(shares);
}

/// Every index in `state` names something of `scene`, in the order it is kept in. For states that
/// come from a file. 0.1 us.
[[nodiscard]] bool fits_scene(const ToolState& state, const ToolScene& scene) noexcept;

}  // namespace hapticd
