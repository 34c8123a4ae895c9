// The knobs of the contact problem: field, range and visit together. SI. RT: yes, plain data.
#pragma once

#include <cmath>
#include <limits>

#include "core/collision/query.h"
#include "core/math/limits.h"
#include "core/math/state_fields.h"

namespace hapticd {

/// The knobs that trade speed for accuracy; the effect of each is measured by tests/benchmark (see
/// README).
struct ContactOptions {
  /// Linearisations per tick, at most; >= 1. A steady contact takes 2 or 3, a slip off an edge up
  /// to some 30; fewer: the tool lags behind for a tick or two while it slips.
  int sub_steps = 32;
  /// Pairs nearer than this enter the program, and no tool point moves further in one
  /// linearisation, m. At most: a tool that moves slowly looks less far.
  double margin = 5e-3;
  /// Clearance of a tool in motion where there is room, m, at most, and below the margin: the
  /// reservoir for the second-order error of rotation; what a step takes of it later ones win
  /// back. Not felt, and gone at rest (clearance.h).
  double skin = 20e-6;
  /// Rotation per linearisation, rad: bounds the second-order error dtheta^2 reach / 2.
  double rotation_step = 0.05;
  /// The tick ends when the step wanted moves no tool point further than this, m.
  double stop_tolerance = 1e-6;
  /// See QueryOptions. A tick that starts within the bounds of a coarse level goes by the leaves. A
  /// change waits until nothing bears force.
  int tool_level = kLeafLevel;
  int body_level = kLeafLevel;
  /// Rows of the program, [1, kMaxQpRows]; fewer: more exchanges of rows, then shorter steps.
  int max_rows = kMaxQpRows;
  /// Speed at which a tool that starts inside something is pushed out, m/s, > 0. Faster throws the
  /// shown tool about, slower prolongs the overlap.
  double recovery_speed = 2.0;
};

/// Fields and ranges, for snapshots and replay (core/math/state_fields.h).
template <FieldsOf<ContactOptions> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [sub_steps, margin, skin, rotation_step, stop_tolerance, tool_level, body_level, max_rows,
         recovery_speed] = state;
  visit.bounded(sub_steps, 1, std::numeric_limits<int>::max());
  visit(margin, skin, rotation_step, stop_tolerance);
  visit.bounded(tool_level, 0, std::numeric_limits<int>::max());
  visit.bounded(body_level, 0, std::numeric_limits<int>::max());
  visit.bounded(max_rows, 1, kMaxQpRows);
  visit(recovery_speed);
}

/// True where the lengths and speeds that the problem divides by or looks as far as are positive
/// and finite, and it looks farther than it keeps off.
[[nodiscard]] inline bool usable(const ContactOptions& options) noexcept {
  return std::isfinite(options.margin) && options.margin > 0.0 && options.skin < options.margin &&
         std::isfinite(options.recovery_speed) && options.recovery_speed > 0.0;
}

}  // namespace hapticd
