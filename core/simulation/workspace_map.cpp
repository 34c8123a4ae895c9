// Device workspace to world. See workspace_map.h. RT: yes.
#include "core/simulation/workspace_map.h"

#include <algorithm>
#include <cmath>

#include "core/safety/pose_guard.h"

namespace hapticd {
namespace {

/// M v of a vector that has an arrow's direction: position, velocity, force.
Vector3 mirrored(Mirror mirror, const Vector3& v) noexcept {
  if (mirror == Mirror::kX) return {-v.x(), v.y(), v.z()};
  if (mirror == Mirror::kZ) return {v.x(), v.y(), -v.z()};
  return v;
}

/// det(M) M w of a vector that has a screw's direction: angular velocity, torque.
Vector3 mirrored_axial(Mirror mirror, const Vector3& w) noexcept {
  return mirror == Mirror::kNone ? w : Vector3(-mirrored(mirror, w));
}

/// Quaternion of M R M, which is a proper rotation.
Quaternion mirrored(Mirror mirror, const Quaternion& q) noexcept {
  const Vector3 axis = mirrored_axial(mirror, q.vec());
  return {q.w(), axis.x(), axis.y(), axis.z()};
}

bool pressed(std::uint32_t buttons, int button) noexcept {
  return button >= 0 && button < 32 && ((buttons >> static_cast<unsigned>(button)) & 1U) != 0;
}

/// The map without c and R_off.
Pose base_pose(const WorkspaceMap& map, const Pose& X_DH) noexcept {
  return {mirrored(map.mirror, map.X_WD.q * X_DH.q),
          mirrored(map.mirror, map.X_WD.p + map.scale * (map.X_WD.q * X_DH.p))};
}

/// Chooses c and R_off so that the device at `X_DH` means the tool at `X_WH`.
void anchor(const WorkspaceMap& map, const Pose& X_DH, const Pose& X_WH,
            WorkspaceState& state) noexcept {
  const Pose base = base_pose(map, X_DH);
  state.c_W = to_array(Vector3(X_WH.p - base.p));
  state.q_off = to_array(renormalised(base.q.conjugate() * X_WH.q));
  state.wrench_share = 0.0;
}

void hold(const Pose& X_WH, WorkspaceState& state) noexcept {
  state.p_held_W = to_array(X_WH.p);
  state.q_held = to_array(X_WH.q);
}

Pose held(const WorkspaceState& state) noexcept {
  return {to_quaternion(state.q_held), to_vector(state.p_held_W)};
}

bool is_unit(const Array4& q) noexcept {
  constexpr double kRounding = 1e-6;
  return std::abs(to_quaternion(q).norm() - 1.0) <= kRounding;
}

}  // namespace

double reach_of(const WorkspaceMap& map, const WorkspaceState& state) noexcept {
  return (kMaxPosition - map.X_WD.p.norm() - to_vector(state.c_W).norm()) / map.scale;
}

bool usable(const WorkspaceState& state) noexcept {
  return to_vector(state.c_W).allFinite() && to_vector(state.p_held_W).allFinite() &&
         is_unit(state.q_off) && is_unit(state.q_held) && std::isfinite(state.wrench_share);
}

Pose to_world(const WorkspaceMap& map, const WorkspaceState& state, const Pose& X_DH) noexcept {
  const Pose base = base_pose(map, X_DH);
  return {renormalised(base.q * to_quaternion(state.q_off)), base.p + to_vector(state.c_W)};
}

Pose to_device(const WorkspaceMap& map, const WorkspaceState& state, const Pose& X_WH) noexcept {
  const Quaternion q_DW = map.X_WD.q.conjugate();
  const Vector3 p = mirrored(map.mirror, Vector3(X_WH.p - to_vector(state.c_W)));
  const Quaternion q =
      mirrored(map.mirror, Quaternion(X_WH.q * to_quaternion(state.q_off).conjugate()));
  return {renormalised(q_DW * q), (q_DW * (p - map.X_WD.p)) / map.scale};
}

Twist to_world(const WorkspaceMap& map, const Twist& V_DH_D) noexcept {
  return {mirrored(map.mirror, Vector3(map.scale * (map.X_WD.q * V_DH_D.v))),
          mirrored_axial(map.mirror, map.X_WD.q * V_DH_D.w)};
}

Twist to_device(const WorkspaceMap& map, const Twist& V_WH_W) noexcept {
  const Quaternion q_DW = map.X_WD.q.conjugate();
  return {(q_DW * mirrored(map.mirror, V_WH_W.v)) / map.scale,
          q_DW * mirrored_axial(map.mirror, V_WH_W.w)};
}

Wrench to_device(const WorkspaceMap& map, const Wrench& F_H_W) noexcept {
  const Quaternion q_DW = map.X_WD.q.conjugate();
  return {q_DW * mirrored(map.mirror, F_H_W.f), q_DW * mirrored_axial(map.mirror, F_H_W.t)};
}

Wrench to_world(const WorkspaceMap& map, const Wrench& F_H_D) noexcept {
  return {mirrored(map.mirror, Vector3(map.X_WD.q * F_H_D.f)),
          mirrored_axial(map.mirror, map.X_WD.q * F_H_D.t)};
}

PlacedHand place(const WorkspaceMap& map, const Pose& X_WG_home, const WorkspaceInput& input,
                 WorkspaceState& state) noexcept {
  const bool recentre_down = pressed(input.buttons, map.recentre_button);
  const bool recentre = input.recentre || (recentre_down && !state.recentre_was_down);
  const bool open = input.clutch_open || pressed(input.buttons, map.clutch_button);
  state.recentre_was_down = recentre_down;

  const double dt_s = std::isfinite(input.dt_s) ? std::clamp(input.dt_s, 0.0, kMaxReturnStep_s) : 0;
  state.wrench_share = std::min(1.0, state.wrench_share + dt_s / kReturnRamp_s);
  if (open && !state.open) hold(to_world(map, state, input.X_DH), state);
  if (!open && state.open) anchor(map, input.X_DH, held(state), state);
  state.open = open;
  if (recentre) {
    anchor(map, input.X_DH, X_WG_home, state);
    hold({renormalised(X_WG_home.q), X_WG_home.p}, state);
  }
  if (open) state.wrench_share = 0.0;

  PlacedHand output;
  output.open = open;
  output.wrench_share = state.wrench_share;
  output.X_WH = open ? held(state) : to_world(map, state, input.X_DH);
  if (!open) output.V_WH_W = to_world(map, input.V_DH_D);
  return output;
}

}  // namespace hapticd
