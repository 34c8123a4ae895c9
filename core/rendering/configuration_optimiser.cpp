// The loop of one tick: query, linearise, solve, step, exact re-check, commit. See
// configuration_optimiser.h. RT: yes.
#include "core/rendering/configuration_optimiser.h"

#include <algorithm>

#include "core/rendering/contact_rows.h"
#include "core/rendering/recovery.h"

namespace hapticd {
namespace {

/// Halvings of a refused step. 2^-8 of the margin is 20 um, the skin: below it the tool may as well
/// wait for the next tick.
constexpr int kMaxHalvings = 8;
/// A new traversal is due when less than this share of the margin is left to move in.
constexpr double kRefreshShare = 0.5;

void query(const OptimiserInput& input, const Pose& X_WG, double reach_wanted,
           OptimiserWorkspace& w, OptimiserResult& result) noexcept {
  const QueryOptions options{.margin = input.options.margin,
                             .horizon = input.options.margin + reach_wanted,
                             .tool_level = w.leaves ? kLeafLevel : input.options.tool_level,
                             .body_level = w.leaves ? kLeafLevel : input.options.body_level};
  find_contacts(input.tool, X_WG, input.obstacles, options, w.contacts);
  ++result.queries;
  result.tests += w.contacts.tests;
  result.minimum_gap = w.contacts.minimum_gap;
  w.travelled = 0.0;
  w.stale = false;
}

/// The contacts at the pose just committed: the same pairs afresh, or a new traversal once the tool
/// has moved out of their range.
void refresh(const OptimiserInput& input, const Pose& X_WG, double reach_wanted,
             OptimiserWorkspace& w, OptimiserResult& result) noexcept {
  if (!w.stale) return;
  const double left = w.contacts.covered_margin - w.travelled;
  if (w.contacts.contacts.empty() || left < kRefreshShare * w.contacts.covered_margin) {
    query(input, X_WG, reach_wanted, w, result);
    return;
  }
  evaluate_contacts(input.tool, X_WG, input.obstacles, w.contacts);
  w.contacts.minimum_gap = std::min(w.contacts.minimum_gap, left);
  result.tests += static_cast<std::int64_t>(w.contacts.contacts.size());
  result.minimum_gap = w.contacts.minimum_gap;
  w.stale = false;
}

void commit(const OptimiserInput& input, const ToolStep& step, const Pose& X_new,
            OptimiserState& state, OptimiserWorkspace& w) noexcept {
  state.X_WG = X_new;
  w.travelled += displacement_bound(step, reach(input.tool));
  w.stale = true;
}

/// Force and active pairs from the multipliers of the full-target program. Zero when the tool only
/// lags in free space, where the spring between G and H would render a phantom.
void take_force(OptimiserState& state, const OptimiserWorkspace& w,
                OptimiserResult& result) noexcept {
  Wrench F_H_W;
  result.active_count = 0;
  state.active_count = 0;
  for (int k = 0; k < w.solution.active_count; ++k) {
    const auto s = static_cast<std::size_t>(k);
    const std::int32_t c = w.contact_of_row[static_cast<std::size_t>(w.solution.active[s])];
    const Contact& contact = w.contacts.contacts[static_cast<std::size_t>(c)];
    const double multiplier = w.solution.multiplier[s];
    const Vector3 f = multiplier * contact.nhat_OG_W;
    F_H_W.f += f;
    F_H_W.t += (contact.p_WC - state.X_WG.p).cross(f);
    result.active[static_cast<std::size_t>(result.active_count++)] = {c, multiplier};
    state.active[static_cast<std::size_t>(state.active_count++)] = {contact.key, multiplier};
  }
  state.F_H_W = F_H_W;
  result.F_H_W = F_H_W;
}

/// The solver's iterates are infeasible until the last, so without an optimum G stays and the force
/// may only shrink.
void keep_after_failure(const OptimiserInput& input, const ToolStep& e, OptimiserState& state,
                        OptimiserResult& result) noexcept {
  const double limit = input.stiffness.kt * e.dp.norm();
  const double before = state.F_H_W.f.norm();
  const double factor = before > limit ? limit / before : 1.0;
  state.F_H_W = {state.F_H_W.f * factor, state.F_H_W.t * factor};
  result.F_H_W = state.F_H_W;
  result.active_count = 0;
  result.status = OptimiserStatus::kQpFailed;
}

/// Largest fraction of `x` that keeps the linearisation valid: no tool point moves further than the
/// pairs not in the program allow.
double step_fraction(const OptimiserInput& input, const OptimiserWorkspace& w,
                     const ToolStep& x) noexcept {
  const double displacement = displacement_bound(x, reach(input.tool));
  const bool nothing_near = w.contacts.contacts.empty();
  const double cap = nothing_near ? w.contacts.minimum_gap - input.options.skin
                                  : w.contacts.covered_margin - w.travelled;
  double fraction = displacement > cap ? cap / displacement : 1.0;
  const double angle = x.dtheta.norm();
  if (!nothing_near && angle * fraction > input.options.rotation_step) {
    fraction = input.options.rotation_step / angle;
  }
  return fraction;
}

/// Exact gaps of every pair that the step could close, at the middle and at the end of the step.
bool clear_of_contacts(const OptimiserInput& input, const OptimiserWorkspace& w, const Pose& X_WG,
                       const ToolStep& step, OptimiserResult& result) noexcept {
  const double displacement = displacement_bound(step, reach(input.tool));
  const Pose X_end = moved(X_WG, step);
  const Pose X_middle = moved(X_WG, scaled(step, 0.5));
  for (const Contact& contact : w.contacts.contacts) {
    if (contact.gap > displacement) continue;
    result.tests += 2;
    if (evaluate_contact(contact.key, input.tool, X_end, input.obstacles).gap < 0.0) return false;
    if (evaluate_contact(contact.key, input.tool, X_middle, input.obstacles).gap < 0.0)
      return false;
  }
  return true;
}

/// Energy that pressing back onto the obstacles will release once more: multiplier times what each
/// touched gap has gained over its linear prediction. Without it every long step along a curved
/// obstacle would look like a climb (the Maratos effect).
double curvature_credit(const OptimiserInput& input, const OptimiserWorkspace& w,
                        const OptimiserResult& result, const Pose& X_new,
                        double fraction) noexcept {
  double credit = 0.0;
  for (int k = 0; k < result.active_count; ++k) {
    const ActiveContact& active = result.active[static_cast<std::size_t>(k)];
    const Contact& contact = w.contacts.contacts[static_cast<std::size_t>(active.contact)];
    const double predicted =
        contact.gap + fraction * std::min(0.0, input.options.skin - contact.gap);
    credit += active.multiplier *
              (evaluate_contact(contact.key, input.tool, X_new, input.obstacles).gap - predicted);
  }
  return credit;
}

/// Halves the step until it neither penetrates nor climbs in energy, then commits it. False when
/// none is admissible.
bool commit_admissible(const OptimiserInput& input, const ToolStep& e, double fraction,
                       OptimiserState& state, OptimiserWorkspace& w,
                       OptimiserResult& result) noexcept {
  const double energy = coupling_energy(input.stiffness, e);
  for (int halving = 0; halving <= kMaxHalvings; ++halving) {
    const ToolStep step = scaled(w.step, fraction);
    const Pose X_new = moved(state.X_WG, step);
    const ToolStep e_new = coupling_error(X_new, input.X_WH, e.dtheta);
    const double credit = curvature_credit(input, w, result, X_new, fraction);
    if (coupling_energy(input.stiffness, e_new) - credit <= energy &&
        clear_of_contacts(input, w, state.X_WG, step, result)) {
      commit(input, step, X_new, state, w);
      state.phi_GH_W = e_new.dtheta;
      return true;
    }
    ++result.halvings;
    fraction *= 0.5;
  }
  return false;
}

}  // namespace

void start_tick(const OptimiserInput& input, const OptimiserState& state, OptimiserWorkspace& w,
                OptimiserResult& result) noexcept {
  result = OptimiserResult{};
  const ToolStep e = coupling_error(state.X_WG, input.X_WH, state.phi_GH_W);
  const double wanted = displacement_bound(e, reach(input.tool));
  w.leaves = input.options.tool_level == kLeafLevel && input.options.body_level == kLeafLevel;
  query(input, state.X_WG, wanted, w, result);
  if (w.contacts.minimum_gap < 0.0 && !w.leaves) {
    // An overlap of bounds is none of the tool; to push it out of them could push a leaf in.
    w.leaves = true;
    query(input, state.X_WG, wanted, w, result);
  }
}

bool advance_sub_step(const OptimiserInput& input, OptimiserState& state, OptimiserWorkspace& w,
                      OptimiserResult& result) noexcept {
  ++result.sub_steps;
  const ToolStep e = coupling_error(state.X_WG, input.X_WH, state.phi_GH_W);
  state.phi_GH_W = e.dtheta;
  const double wanted = displacement_bound(e, reach(input.tool));
  refresh(input, state.X_WG, wanted, w, result);

  if (wanted <= w.contacts.minimum_gap - input.options.skin) {
    commit(input, e, input.X_WH, state, w);
    state.phi_GH_W = Vector3::Zero();
    state.F_H_W = Wrench{};
    state.active_count = 0;
    result.F_H_W = Wrench{};
    result.active_count = 0;
    result.status = OptimiserStatus::kFree;
    return false;
  }

  const double holds = solve_linearisation(input, state, e, w, result);
  if (w.solution.status != QpStatus::kOptimal) {
    keep_after_failure(input, e, state, result);
    return false;
  }
  take_force(state, w, result);
  const ToolStep& x = w.step;
  const bool converged = displacement_bound(x, reach(input.tool)) < input.options.stop_tolerance;
  const double fraction = std::min(holds, step_fraction(input, w, x));
  const bool moved_on = commit_admissible(input, e, fraction, state, w, result);
  result.status = converged  ? OptimiserStatus::kConverged
                  : moved_on ? OptimiserStatus::kLagging
                             : OptimiserStatus::kRefused;
  return !converged && moved_on;
}

void optimise_configuration(const OptimiserInput& input, OptimiserState& state,
                            OptimiserWorkspace& w, OptimiserResult& result) noexcept {
  start_tick(input, state, w, result);
  if (w.contacts.minimum_gap < 0.0) {
    recover(input, state, w, result);
    return;
  }
  while (result.sub_steps < input.options.sub_steps && advance_sub_step(input, state, w, result)) {
  }
}

}  // namespace hapticd
