// The loop of one tick: query, linearise, solve, step, exact re-check, commit. See
// configuration_optimiser.h. RT: yes.
#include "core/contact/configuration_optimiser.h"

#include <algorithm>
#include <cmath>

#include "core/contact/candidates.h"
#include "core/contact/contact_rows.h"
#include "core/contact/hold_model.h"
#include "core/contact/recovery.h"
#include "core/contact/stationarity.h"
#include "core/contact/step_admission.h"
#include "core/contact/string_forces.h"
#include "core/contact/tick_work.h"

namespace hapticd {
namespace {

/// Share by which the energy of a force may exceed all that is stored before the force is shrunk: a
/// tool at rest comes within rounding of it. Larger: a spike of half of it passes.
constexpr double kEnergySlack = 0.01;
/// By what share of the last one, 1 in so many, the next linearisation may be dearer. Larger: more
/// ticks go beyond their work budget.
constexpr std::int64_t kDearerNext = 8;

/// How often the way of a string back to rest is halved where another tool is in it.
constexpr int kStraighteningHalvings = 8;

/// The way of any point of the tool relative to any of a string when nothing holds either back, m.
double free_way(const OptimiserInput& input, const ToolStep& e,
                const OptimiserState& state) noexcept {
  double parts = 0.0;
  for (const SoftPart& soft : state.parts) {
    const Vector3 v_G = free_displacement(input.parts, input.dt, soft);
    parts = std::max(parts, (v_G - soft.v_G).norm());
  }
  return displacement_bound(e, tool_reach(input, state) + parts) + parts +
         greatest_deflection(state.holds);
}

/// Lets all strings go to rest, or as far towards it as other tools let them; those stay held.
void straighten(const OptimiserInput& input, StringHolds& holds) noexcept {
  std::size_t kept = 0;
  for (std::size_t k = 0; !input.others.tools.empty() && k < holds.size(); ++k) {
    StringHold hold = holds[k];
    if (!hold.yields) continue;
    StringMotion motion{-hold.bend.u_W, 0.0, 0.0};
    const Capsule& line = input.obstacles.capsules_W[static_cast<std::size_t>(hold.bend.capsule)];
    int halving = 0;
    while (halving <= kStraighteningHalvings &&
           !clear_of_bystanders(input.others, line, hold.bend, motion)) {
      motion = scaled(motion, 0.5);
      ++halving;
    }
    if (halving == 0) continue;
    if (halving <= kStraighteningHalvings) hold.bend = moved(hold.bend, motion);
    hold.normal_force = 0.0;
    hold.tangential_W = Vector3::Zero();
    hold.slip_W = Vector3::Zero();
    holds[kept++] = hold;
  }
  if (kept == 0) {
    holds.clear();
  } else {
    holds.truncate(kept);
  }
}

/// The free way: G reaches H, all strings are at rest, soft parts go there as their dampers let
/// them.
void commit_free(const OptimiserInput& input, double way, OptimiserState& state,
                 OptimiserWorkspace& w, OptimiserResult& result) noexcept {
  w.travelled += way;
  state.way += way;
  w.stale = true;
  state.X_WG = input.X_WH;
  straighten(input, state.holds);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < state.parts.size(); ++k) {
    SoftPart soft = state.parts[k];
    soft.v_G = free_displacement(input.parts, input.dt, soft);
    if (soft.v_G.squaredNorm() > 0.0) state.parts[kept++] = soft;
  }
  state.parts.truncate(kept);
  state.phi_GH_W = Vector3::Zero();
  state.F_H_W = Wrench{};
  state.active_count = 0;
  result.F_H_W = Wrench{};
  result.active_count = 0;
  result.status = OptimiserStatus::kFree;
}

/// Adds what friction and strings that pull along their axis do to the tool at the end of the full
/// step, friction within mu N.
void add_hold_forces(const OptimiserInput& input, const OptimiserWorkspace& w,
                     OptimiserState& state, Wrench& F_H_W) noexcept {
  for (std::size_t k = 0; k < state.holds.size(); ++k) {
    const HoldModel& model = w.models[k];
    StringHold& hold = state.holds[k];
    hold.tangential_W = Vector3::Zero();
    if (!model.touched) continue;
    Vector3 f = model.lateral_force * model.axis_W;
    const auto index = static_cast<std::size_t>(hold.bend.capsule);
    const double limit = input.strings[index].friction_coefficient * hold.normal_force;
    if (input.instrument.friction && limit > 0.0) {
      const ConfigurationStep& step = w.step;
      const Vector3 slip = model.slip_W + slip_motion(model, hold.bend, step, step.strings[k].du_W);
      const double length = slip.norm();
      const double stiffness = input.instrument.anchor_stiffness;
      f -= (stiffness * length > limit ? limit / length : stiffness) * slip;
    }
    hold.tangential_W = f;
    F_H_W.f += f;
    F_H_W.t += model.p_GC_W.cross(f);
  }
}

/// Shrinks forces that all springs together cannot give: none may press the tool harder than
/// letting all their energy go into the coupling. At rest forces are what the coupling's is and far
/// below; the multipliers of a program far from rest, on tightly turning contacts, know no bound.
void bound_forces(const OptimiserInput& input, const ToolStep& e, const OptimiserWorkspace& w,
                  OptimiserState& state, OptimiserResult& result, Wrench& F_H_W) noexcept {
  const double given = 0.5 * (F_H_W.f.squaredNorm() / input.stiffness.kt +
                              F_H_W.t.squaredNorm() / input.stiffness.kr());
  double stored = coupling_energy(input.stiffness, e);
  if (given <= (1.0 + kEnergySlack) * stored) return;
  const StringContext context = string_context(input);
  for (std::size_t k = 0; k < state.holds.size(); ++k) {
    const StringHold& hold = state.holds[k];
    if (hold.yields) stored += string_law(context, hold.bend, hold.bend.u_W.norm()).energy;
    stored += 0.5 * w.models[k].slip_stiffness * w.models[k].slip_W.squaredNorm();
  }
  for (std::size_t k = 0; k < state.parts.size(); ++k) {
    stored += 0.5 * w.parts[k].stiffness * w.parts[k].off_G.squaredNorm();
  }
  if (given <= (1.0 + kEnergySlack) * stored) return;
  const double factor = std::sqrt(stored / given);
  F_H_W = {F_H_W.f * factor, F_H_W.t * factor};
  for (int k = 0; k < result.active_count; ++k) {
    result.active[static_cast<std::size_t>(k)].multiplier *= factor;
    state.active[static_cast<std::size_t>(k)].multiplier *= factor;
  }
  for (StringHold& hold : state.holds) {
    hold.normal_force *= factor;
    hold.tangential_W *= factor;
  }
}

/// Force and active pairs from the multipliers of the full-target program. Zero when the tool only
/// lags in free space, where the spring between G and H would render a phantom.
void take_force(const OptimiserInput& input, const ToolStep& e, OptimiserState& state,
                const OptimiserWorkspace& w, OptimiserResult& result) noexcept {
  Wrench F_H_W;
  result.active_count = 0;
  state.active_count = 0;
  std::array<Vector3, kMaxDeflectingStrings> hold_force;
  std::array<double, kMaxDeflectingStrings> hold_lambda;
  std::array<double, kMaxDeflectingStrings> hold_weight;
  for (std::size_t k = 0; k < state.holds.size(); ++k) {
    hold_force[k] = Vector3::Zero();
    hold_lambda[k] = hold_weight[k] = 0.0;
  }
  for (int k = 0; k < w.solution.active_count; ++k) {
    const auto s = static_cast<std::size_t>(k);
    const std::int32_t c = w.contact_of_row[static_cast<std::size_t>(w.solution.active[s])];
    const Contact& contact = w.contacts.contacts[static_cast<std::size_t>(c)];
    const double multiplier = w.solution.multiplier[s];
    const GapGradient gradient = gap_gradient(state, w.models, contact);
    const Vector3 f = multiplier * gradient.linear;
    F_H_W.f += f;
    F_H_W.t += multiplier * gradient.angular;
    result.active[static_cast<std::size_t>(result.active_count++)] = {c, multiplier};
    state.active[static_cast<std::size_t>(state.active_count++)] = {contact.key, multiplier};
    if (gradient.hold < 0) continue;
    const auto hold = static_cast<std::size_t>(gradient.hold);
    hold_force[hold] += f;
    hold_lambda[hold] += multiplier * contact.lambda;
    hold_weight[hold] += multiplier;
  }
  // Friction is held by what the string gives, not by what the program presses on it.
  for (std::size_t k = 0; k < state.holds.size(); ++k) {
    StringHold& hold = state.holds[k];
    hold.normal_force = 0.0;
    if (!input.instrument.friction || !(hold_weight[k] > 0.0)) continue;
    const double lambda = hold_lambda[k] / hold_weight[k];
    hold.normal_force = string_load(input, &hold, hold.bend.capsule, lambda, hold_force[k]).force;
  }
  add_hold_forces(input, w, state, F_H_W);
  bound_forces(input, e, w, state, result, F_H_W);
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

/// Takes up and lets go of soft parts and strings, which moves nothing.
void update_touched(const OptimiserInput& input, double wanted, OptimiserState& state,
                    OptimiserWorkspace& w, OptimiserResult& result) noexcept {
  if (!input.parts.parts.empty()) {
    update_parts(input.parts, w.contacts, kHoldSkins * input.options.skin, state.parts,
                 result.parts_refused);
  }
  if (!input.strings.empty() && update_holds(string_context(input), w.contacts, input.options.skin,
                                             state.holds, result.strings_refused)) {
    find_candidates(input, state, wanted, w, result);
  }
}

}  // namespace

void start_tick(const OptimiserInput& input, OptimiserState& state, OptimiserWorkspace& w,
                OptimiserResult& result) noexcept {
  result = OptimiserResult{};
  start_parts(input.parts, state.parts);
  const ToolStep e = coupling_error(state.X_WG, input.X_WH, state.phi_GH_W);
  const double wanted = displacement_bound(e, tool_reach(input, state));
  const ToolStep hand = coupling_error(state.X_WH, input.X_WH, Vector3::Zero());
  w.pace = std::max(state.way, displacement_bound(hand, tool_reach(input, state)));
  state.X_WH = input.X_WH;
  state.way = 0.0;
  if (state.active_count == 0) {
    state.tool_level = input.options.tool_level;
    state.body_level = input.options.body_level;
  }
  w.leaves =
      (state.tool_level == kLeafLevel && state.body_level == kLeafLevel) || any_soft(input.parts);
  find_candidates(input, state, wanted, w, result);
  if (w.contacts.minimum_gap < -input.rounding) {
    // An overlap of bounds is none of the tool; to push it out of them could push a leaf in. What
    // is pushed out looks at all.
    w.leaves = true;
    w.pace = input.options.margin;
    find_candidates(input, state, wanted, w, result);
  }
  w.linearised = linearisation_work(result);
}

ToolStep prepare_sub_step(const OptimiserInput& input, OptimiserState& state, OptimiserWorkspace& w,
                          OptimiserResult& result) noexcept {
  ToolStep e = coupling_error(state.X_WG, input.X_WH, state.phi_GH_W);
  const double wanted = displacement_bound(e, tool_reach(input, state));
  refresh_candidates(input, state, wanted, w, result);
  update_touched(input, wanted, state, w, result);
  return e;
}

bool advance_sub_step(const OptimiserInput& input, OptimiserState& state, OptimiserWorkspace& w,
                      OptimiserResult& result) noexcept {
  ++result.sub_steps;
  Wrench settled_F_H_W;
  const ToolStep e = prepare_sub_step(input, state, w, result);
  state.phi_GH_W = e.dtheta;
  const double way = free_way(input, e, state);
  if (way <= w.contacts.minimum_gap - input.options.skin) {
    commit_free(input, way, state, w, result);
    return false;
  }
  if (w.full_step && is_stationary(input, state, e, w, result, settled_F_H_W)) {
    --result.sub_steps;
    state.F_H_W = settled_F_H_W;
    result.F_H_W = settled_F_H_W;
    result.status = OptimiserStatus::kConverged;
    return false;
  }

  result.pressed += state.active_count;
  const double holds = solve_linearisation(input, state, e, w, result);
  if (w.solution.status != QpStatus::kOptimal) {
    keep_after_failure(input, e, state, result);
    return false;
  }
  take_force(input, e, state, w, result);
  const bool last = step_bound(input, state, w.step) < input.options.stop_tolerance;
  const bool moved_on = commit_admissible(input, e, holds, last, state, w, result);
  const bool converged = last || step_bound(input, state, w.step) < input.options.stop_tolerance;
  result.status = converged  ? OptimiserStatus::kConverged
                  : moved_on ? OptimiserStatus::kLagging
                             : OptimiserStatus::kRefused;
  return !converged && moved_on;
}

bool work_used_up(const OptimiserInput& input, const OptimiserResult& result,
                  OptimiserWorkspace& w) noexcept {
  if (input.work_budget <= 0) return false;
  const std::int64_t last = linearisation_work(result) - w.linearised;
  w.linearised += last;
  return tick_work(result) + last + last / kDearerNext + tests_of_next_look(w) > input.work_budget;
}

void finish_tick(const OptimiserInput& input, OptimiserState& state) noexcept {
  if (!input.instrument.friction) return;
  for (StringHold& hold : state.holds) {
    const auto index = static_cast<std::size_t>(hold.bend.capsule);
    const double longest = input.strings[index].friction_coefficient * hold.normal_force /
                           input.instrument.anchor_stiffness;
    const double slip = hold.slip_W.norm();
    if (slip > longest) hold.slip_W *= longest / slip;
  }
}

void optimise_configuration(const OptimiserInput& input, OptimiserState& state,
                            OptimiserWorkspace& w, OptimiserResult& result) noexcept {
  start_tick(input, state, w, result);
  if (w.contacts.minimum_gap < -input.rounding) {
    recover(input, state, w, result);
    return;
  }
  bool more = true;
  while (more && result.sub_steps < input.options.sub_steps && !result.cut_short) {
    more = advance_sub_step(input, state, w, result);
    result.cut_short = more && work_used_up(input, result, w);
  }
  finish_tick(input, state);
}

}  // namespace hapticd
