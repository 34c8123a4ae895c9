// Chains the hand's motion, contact problem, force bound and limit. See tool_renderer.h. RT: yes.
#include "core/simulation/tool_renderer.h"

#include <algorithm>
#include <cmath>

#include "core/math/assert.h"
#include "core/math/rotation.h"

namespace hapticd {
namespace {

/// Force bound of this tick: clamped while recovering, then growing until the contact force fits
/// under it.
double next_force_bound(double bound, ContactStatus status, double force, double dt) noexcept {
  if (status == ContactStatus::kRecovering) {
    const double start = std::isfinite(bound) ? bound : 0.0;
    return std::min(start + kRecoveryForceRate * dt, kRecoveryForce);
  }
  const double grown = bound + kRecoveryForceRate * dt;
  return force <= grown ? std::numeric_limits<double>::infinity() : grown;
}

/// The stiffness of the program, and of strings that give less than the program presses on them
/// that much less.
ContactStiffness felt_stiffness(const ContactProblem& problem, const RenderedTool& tick) noexcept {
  ContactStiffness stiffness = contact_stiffness(problem.view(), problem.unknowns());
  const double pressed = tick.contact.F_H_W.f.norm();
  const double felt = tick.F_computed_H_W.f.norm();
  if (felt < pressed) {
    stiffness.K_W *= felt / pressed;
    stiffness.Kr_W *= felt / pressed;
  }
  return stiffness;
}

}  // namespace

double follow(const HandPose& hand, HandMotion& motion) noexcept {
  // The placed pose is normalised once more: it is what forces have always been computed from.
  const Pose X_WH{renormalised(to_quaternion(hand.q_WH)), to_vector(hand.p_WH)};
  HD_ASSERT(X_WH.p.allFinite() && X_WH.q.coeffs().allFinite());
  double dt_s = 0.0;
  if (motion.has_pose && hand.t_ns > motion.t_ns) {
    const double elapsed_s = 1e-9 * static_cast<double>(hand.t_ns - motion.t_ns);
    const Pose& before = motion.X_WH;
    motion.V_WH = {(X_WH.p - before.p) / elapsed_s,
                   log_rotation(X_WH.q * before.q.conjugate()) / elapsed_s};
    dt_s = std::min(elapsed_s, kMaxElapsed);
  }
  motion.X_WH = X_WH;
  motion.t_ns = motion.has_pose ? std::max(motion.t_ns, hand.t_ns) : hand.t_ns;
  motion.has_pose = true;
  return dt_s;
}

ContactInput contact_input(const ToolScene& scene, const Pose& X_WH, double dt) noexcept {
  return {scene.tool,           scene.obstacles,  X_WH,
          scene.stiffness,      scene.options,    dt,
          scene.strings,        scene.instrument, scene.parts,
          scene.others,         scene.rounding,   0,
          scene.rigid_friction, scene.clock,      scene.rigid_parts};
}

void render_contact(const ToolScene& scene, const HandPose& hand, ToolState& state,
                    ContactProblem& problem, RenderedTool& tick,
                    std::int64_t work_budget) noexcept {
  tick.dt = follow(hand, state.hand);
  tick.X_WH = state.hand.X_WH;
  tick.V_WH = state.hand.V_WH;
  tick.strings.clear();
  tick.stiffness = ContactStiffness{};
  if (!state.placed) {
    state.contact.X_WG = tick.X_WH;
    state.placed = true;
  }
  ContactInput input = contact_input(scene, tick.X_WH, tick.dt);
  input.obstacles.blends = &problem.blends();
  input.work_budget = work_budget;
  problem.solve(input, state.contact, tick.contact);
  tick.X_WG = state.contact.X_WG;
  find_string_contacts(problem.view(), tick.strings, tick.F_computed_H_W);
  if (scene.stiffness_wanted) tick.stiffness = felt_stiffness(problem, tick);
}

void limit_wrench(const ToolScene& scene, ToolState& state, RenderedTool& tick) noexcept {
  const double force = tick.F_computed_H_W.f.norm();
  state.force_bound = next_force_bound(state.force_bound, tick.contact.status, force, tick.dt);
  const double factor = force > state.force_bound ? state.force_bound / force : 1.0;
  tick.F_H_W =
      limited({tick.F_computed_H_W.f * factor, tick.F_computed_H_W.t * factor}, scene.limits);
}

}  // namespace hapticd
