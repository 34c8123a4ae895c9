// One axis of the simulated handle over one sub-step: mass, viscous damping and, where an arm holds
// it, a spring and damper toward a target, under a force that is constant within the sub-step, with
// Coulomb friction. The linear part is the exact solution where the sub-step resolves it, else
// backward Euler, so that it is stable for every mass, damping and stiffness. Friction is implicit:
// it takes away at most the velocity there is, so a handle at rest sticks without chatter. Without
// libm, so the same bits with every compiler. SI; for rotation read mass as inertia, force as
// torque. RT: yes, about 5 ns.
#pragma once

#include "core/math/realtime.h"

namespace hapticd {

/// What one axis is made of.
struct AxisPlant {
  double mass = 1.0;         ///< of handle and hand, > 0
  double damping = 0.0;      ///< toward the ground, >= 0
  double arm_damping = 0.0;  ///< toward the target, >= 0
  double stiffness = 0.0;    ///< toward the target, >= 0
  double coulomb = 0.0;      ///< friction, >= 0
};

/// The same, solved for one length of sub-step. y = distance from the target, w = its rate.
struct AxisResponse {
  double dt = 0.0;
  double damping = 0.0;
  double coulomb = 0.0;
  double y_y = 1.0;  ///< y after per y before
  double y_w = 0.0;
  double y_f = 0.0;  ///< y after per force
  double w_y = 0.0;
  double w_w = 1.0;
  double w_f = 0.0;
};

/// Solves `plant` for sub-steps of `dt` s, > 0.
[[nodiscard]] AxisResponse make_axis_response(const AxisPlant& plant, double dt) noexcept;

/// One axis at one instant.
struct AxisState {
  double y = 0.0;         ///< from the target, m
  double v = 0.0;         ///< velocity, m/s
  double v_target = 0.0;  ///< velocity of the target, constant within the sub-step, m/s
};

/// What a sub-step did.
struct AxisStep {
  double moved = 0.0;  ///< distance gone, m
  double v = 0.0;      ///< velocity after, m/s
};

/// One sub-step under `force`, N.
[[nodiscard]] HD_REALTIME AxisStep advance_axis(const AxisResponse& response,
                                                const AxisState& state, double force) noexcept;

}  // namespace hapticd
