// The loop of one tick: query, linearise, solve, step, exact re-check, commit. See
// configuration_optimiser.h. RT: yes.
#include "core/rendering/configuration_optimiser.h"

#include <algorithm>

#include "core/rendering/contact_rows.h"
#include "core/rendering/hold_model.h"
#include "core/rendering/recovery.h"

namespace hapticd {
namespace {

/// Halvings of a refused step. 2^-8 of the margin is 20 um, the skin: below it the tool may as well
/// wait for the next tick.
constexpr int kMaxHalvings = 8;
/// Share of the energy by which it may seem to climb where strings yield: their energy is rounded
/// apart from the coupling's. Normal 1e-16; smaller would refuse steps at rest, which costs time
/// alone.
constexpr double kEnergyRounding = 1e-13;
/// What may hide between two places of a path that are looked at, m: less than half of what the
/// path may penetrate. Smaller: more evaluations where a short leg of a string turns.
constexpr double kPathError = 0.4e-6;
/// Places looked at in a step, at most; a step that needs more is shortened.
constexpr double kMaxPathSamples = 16.0;
/// Turn of a leg that counts as any turn, rad.
constexpr double kGreatestLegTurn = 2.0;
/// A new traversal is due when less than this share of the margin is left to move in.
constexpr double kRefreshShare = 0.5;

void query(const OptimiserInput& input, const OptimiserState& state, double reach_wanted,
           OptimiserWorkspace& w, OptimiserResult& result) noexcept {
  const QueryOptions options{.margin = input.options.margin,
                             .horizon = input.options.margin + reach_wanted,
                             .tool_level = w.leaves ? kLeafLevel : input.options.tool_level,
                             .body_level = w.leaves ? kLeafLevel : input.options.body_level};
  const BentObstacles bent(input.obstacles, state.holds);
  find_contacts(input.tool, state.X_WG, bent.view(), options, w.contacts);
  ++result.queries;
  result.tests += w.contacts.tests;
  result.minimum_gap = w.contacts.minimum_gap;
  w.travelled = 0.0;
  w.stale = false;
}

/// The contacts at the pose just committed: the same pairs afresh, or a new traversal once the tool
/// has moved out of their range.
void refresh(const OptimiserInput& input, const OptimiserState& state, double reach_wanted,
             OptimiserWorkspace& w, OptimiserResult& result) noexcept {
  if (!w.stale) return;
  const double left = w.contacts.covered_margin - w.travelled;
  if (w.contacts.contacts.empty() || left < kRefreshShare * w.contacts.covered_margin) {
    query(input, state, reach_wanted, w, result);
    return;
  }
  const BentObstacles bent(input.obstacles, state.holds);
  evaluate_contacts(input.tool, state.X_WG, bent.view(), w.contacts);
  w.contacts.minimum_gap = std::min(w.contacts.minimum_gap, left);
  result.tests += static_cast<std::int64_t>(w.contacts.contacts.size());
  result.minimum_gap = w.contacts.minimum_gap;
  w.stale = false;
}

/// Upper bound of the way of any point of the tool relative to any of a string in `step`, m.
double step_bound(const OptimiserInput& input, const OptimiserState& state,
                  const ConfigurationStep& step) noexcept {
  double strings = 0.0;
  for (std::size_t k = 0; k < state.holds.size(); ++k) {
    const auto index = static_cast<std::size_t>(state.holds[k].bend.capsule);
    strings = std::max(strings, displacement_bound(step.strings[k], input.strings[index].length));
  }
  return displacement_bound(step.tool, reach(input.tool)) + strings;
}

/// `step` times `factor`.
ConfigurationStep scaled(const ConfigurationStep& step, double factor) noexcept {
  ConfigurationStep out;
  out.tool = scaled(step.tool, factor);
  for (std::size_t k = 0; k < step.strings.size(); ++k) {
    out.strings[k] = {step.strings[k].du_W * factor, step.strings[k].dlambda * factor};
  }
  return out;
}

/// The holds with their strings moved by `step`.
StringHolds moved(const StringHolds& holds, const ConfigurationStep& step) noexcept {
  StringHolds out = holds;
  for (std::size_t k = 0; k < out.size(); ++k) out[k].bend = moved(out[k].bend, step.strings[k]);
  return out;
}

/// The free way: G reaches H, and all strings are at rest.
void commit_free(const OptimiserInput& input, const ToolStep& e, OptimiserState& state,
                 OptimiserWorkspace& w, OptimiserResult& result) noexcept {
  w.travelled += displacement_bound(e, reach(input.tool)) + greatest_deflection(state.holds);
  w.stale = true;
  state.X_WG = input.X_WH;
  state.holds.clear();
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
    if (!model.touched) continue;
    StringHold& hold = state.holds[k];
    Vector3 f = model.lateral_force * model.axis_W;
    const auto index = static_cast<std::size_t>(hold.bend.capsule);
    const double limit = input.strings[index].friction_coefficient * hold.normal_force;
    if (input.instrument.friction && limit > 0.0) {
      const ConfigurationStep& step = w.step;
      const Vector3 slip =
          hold.slip_W + slip_motion(model, hold.bend, step.tool, step.strings[k].du_W);
      const double length = slip.norm();
      const double stiffness = input.instrument.anchor_stiffness;
      f -= (stiffness * length > limit ? limit / length : stiffness) * slip;
    }
    F_H_W.f += f;
    F_H_W.t += model.p_GC_W.cross(f);
  }
}

/// Force and active pairs from the multipliers of the full-target program. Zero when the tool only
/// lags in free space, where the spring between G and H would render a phantom.
void take_force(const OptimiserInput& input, OptimiserState& state, const OptimiserWorkspace& w,
                OptimiserResult& result) noexcept {
  Wrench F_H_W;
  result.active_count = 0;
  state.active_count = 0;
  std::array<Vector3, kMaxDeflectingStrings> hold_force;
  hold_force.fill(Vector3::Zero());
  for (int k = 0; k < w.solution.active_count; ++k) {
    const auto s = static_cast<std::size_t>(k);
    const std::int32_t c = w.contact_of_row[static_cast<std::size_t>(w.solution.active[s])];
    const Contact& contact = w.contacts.contacts[static_cast<std::size_t>(c)];
    const double multiplier = w.solution.multiplier[s];
    const Vector3 f = multiplier * force_direction(state, w.models, contact);
    F_H_W.f += f;
    F_H_W.t += (contact.p_WC - state.X_WG.p).cross(f);
    result.active[static_cast<std::size_t>(result.active_count++)] = {c, multiplier};
    state.active[static_cast<std::size_t>(state.active_count++)] = {contact.key, multiplier};
    const int h = find_hold(state.holds, contact.key);
    if (h >= 0) hold_force[static_cast<std::size_t>(h)] += f;
  }
  for (std::size_t k = 0; k < state.holds.size(); ++k) {
    state.holds[k].normal_force = hold_force[k].norm();
  }
  add_hold_forces(input, w, state, F_H_W);
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

/// Largest fraction of the full step that keeps the linearisation valid: no tool point moves
/// further than the pairs not in the program allow.
double step_fraction(const OptimiserInput& input, const OptimiserState& state,
                     const OptimiserWorkspace& w) noexcept {
  const double displacement = step_bound(input, state, w.step);
  const bool nothing_near = w.contacts.contacts.empty();
  const double cap = nothing_near ? w.contacts.minimum_gap - input.options.skin
                                  : w.contacts.covered_margin - w.travelled;
  double fraction = displacement > cap ? cap / displacement : 1.0;
  const double angle = w.step.tool.dtheta.norm();
  if (!nothing_near && angle * fraction > input.options.rotation_step) {
    fraction = input.options.rotation_step / angle;
  }
  return fraction;
}

/// Smallest distance from a string's axis to the centre of a tool sphere that touches it, m.
double smallest_distance(const OptimiserInput& input, const ContactSet& contacts,
                         std::int32_t capsule) noexcept {
  double smallest = std::numeric_limits<double>::infinity();
  const double R = input.obstacles.capsules_W[static_cast<std::size_t>(capsule)].r;
  for (const Contact& contact : contacts.contacts) {
    if (contact.key.kind != ObstacleKind::kCapsule || contact.key.obstacle != capsule) continue;
    smallest = std::min(smallest, R + tree_sphere(input.tool, contact.key.tool_sphere).r);
  }
  return smallest;
}

/// How many places of the step have to be looked at so that no more than kPathError hides between
/// them. The rows keep a tool out of what is convex and goes straight. Where a leg of a string
/// turns by phi, the nearest point slides along it by up to phi (d + way), or the leg's length:
/// against such a point the tool's way w may bend inwards by its share of w^2 / (8 d), the sagitta.
double path_samples(const OptimiserInput& input, const OptimiserState& state,
                    const OptimiserWorkspace& w, const ConfigurationStep& step) noexcept {
  double error = 0.0;
  for (std::size_t k = 0; k < state.holds.size(); ++k) {
    const StringHold& hold = state.holds[k];
    const StringMotion& motion = step.strings[k];
    if (!hold.yields || (motion.dlambda == 0.0 && motion.du_W.isZero(0.0))) continue;
    const double length = input.strings[static_cast<std::size_t>(hold.bend.capsule)].length;
    const double d = smallest_distance(input, w.contacts, hold.bend.capsule);
    const StringBend end = moved(hold.bend, motion);
    const double turned = displacement_bound(motion, length);
    const double way = displacement_bound(step.tool, reach(input.tool)) + turned;
    const double from_length = hold.bend.u_W.norm();
    const double to_length = end.u_W.norm();
    for (const bool first : {true, false}) {
      const double from =
          from_length + length * (first ? hold.bend.lambda : 1.0 - hold.bend.lambda);
      const double to = to_length + length * (first ? end.lambda : 1.0 - end.lambda);
      const double phi = turned < kGreatestLegTurn * std::min(from, to)
                             ? turned / std::min(from, to)
                             : kGreatestLegTurn;
      const double slide = std::min(std::max(from, to), phi * (d + way));
      if (slide * slide > 2.0 * d * kPathError) error = std::max(error, 0.125 * way * way / d);
    }
  }
  return std::sqrt(error / kPathError);
}

/// Exact gaps of every pair that the step could close, at its end and at `samples` - 1 places
/// before.
bool clear_of_contacts(const OptimiserInput& input, const OptimiserState& state,
                       const OptimiserWorkspace& w, const ConfigurationStep& step, int samples,
                       OptimiserResult& result) noexcept {
  const double displacement = step_bound(input, state, step);
  for (int k = samples; k > 0; --k) {
    const ConfigurationStep part = scaled(step, static_cast<double>(k) / samples);
    const Pose X = moved(state.X_WG, part.tool);
    const BentObstacles bent(input.obstacles, moved(state.holds, part));
    for (const Contact& contact : w.contacts.contacts) {
      if (contact.gap > displacement) continue;
      ++result.tests;
      if (evaluate_contact(contact.key, input.tool, X, bent.view()).gap < 0.0) return false;
    }
  }
  return true;
}

/// Energy that pressing back onto the obstacles will release once more: multiplier times what each
/// touched gap has gained over its linear prediction. Without it every long step along a curved
/// obstacle would look like a climb (the Maratos effect).
double curvature_credit(const OptimiserInput& input, const OptimiserWorkspace& w,
                        const OptimiserResult& result, const Pose& X_new,
                        const ObstaclesView& obstacles, double fraction) noexcept {
  double credit = 0.0;
  for (int k = 0; k < result.active_count; ++k) {
    const ActiveContact& active = result.active[static_cast<std::size_t>(k)];
    const Contact& contact = w.contacts.contacts[static_cast<std::size_t>(active.contact)];
    const double predicted =
        contact.gap + fraction * std::min(0.0, input.options.skin - contact.gap);
    credit += active.multiplier *
              (evaluate_contact(contact.key, input.tool, X_new, obstacles).gap - predicted);
  }
  return credit;
}

/// What the held strings gain in energy over `step`: elastic at the new place of the vertex (a
/// string gives no force along its axis unless asked to, so what sliding changes is no work), and
/// friction.
double string_energy_gain(const OptimiserInput& input, const OptimiserState& state,
                          const HoldModels& models, const ConfigurationStep& step) noexcept {
  double gain = 0.0;
  const StringContext context = string_context(input);
  for (std::size_t k = 0; k < state.holds.size(); ++k) {
    const StringHold& hold = state.holds[k];
    const StringMotion& motion = step.strings[k];
    if (hold.yields) {
      const StringBend end = moved(hold.bend, motion);
      StringBend start = end;
      start.u_W = hold.bend.u_W;
      gain += string_law(context, end, end.u_W.norm()).energy -
              string_law(context, start, start.u_W.norm()).energy;
      const double slid = step.tool.dp.dot(models[k].axis_W) +
                          step.tool.dtheta.cross(models[k].p_GC_W).dot(models[k].axis_W);
      gain -= models[k].lateral_force * slid;
    }
    if (models[k].slip_stiffness > 0.0) {
      const auto index = static_cast<std::size_t>(hold.bend.capsule);
      const double limit = input.strings[index].friction_coefficient * hold.normal_force;
      const Vector3 slip = hold.slip_W + slip_motion(models[k], hold.bend, step.tool, motion.du_W);
      const double stiffness = input.instrument.anchor_stiffness;
      gain += slip_energy(stiffness, limit, slip.norm()) -
              slip_energy(stiffness, limit, hold.slip_W.norm());
    }
  }
  return gain;
}

void commit(const OptimiserInput& input, const ConfigurationStep& step, const Pose& X_new,
            OptimiserState& state, OptimiserWorkspace& w) noexcept {
  w.travelled += step_bound(input, state, step);
  w.stale = true;
  state.X_WG = X_new;
  for (std::size_t k = 0; k < state.holds.size(); ++k) {
    StringHold& hold = state.holds[k];
    if (input.instrument.friction && w.models[k].touched) {
      hold.slip_W += slip_motion(w.models[k], hold.bend, step.tool, step.strings[k].du_W);
    }
    hold.bend = moved(hold.bend, step.strings[k]);
  }
}

/// Halves the step until it neither penetrates nor climbs in energy, then commits it. False when
/// none is admissible.
bool commit_admissible(const OptimiserInput& input, const ToolStep& e, double fraction,
                       OptimiserState& state, OptimiserWorkspace& w,
                       OptimiserResult& result) noexcept {
  const double energy = coupling_energy(input.stiffness, e);
  const double rounding = state.holds.empty() ? 0.0 : kEnergyRounding * energy;
  const double samples_of_full_step = path_samples(input, state, w, w.step);
  if (fraction * samples_of_full_step > kMaxPathSamples) {
    fraction = kMaxPathSamples / samples_of_full_step;
  }
  for (int halving = 0; halving <= kMaxHalvings; ++halving) {
    const ConfigurationStep step = scaled(w.step, fraction);
    const Pose X_new = moved(state.X_WG, step.tool);
    const ToolStep e_new = coupling_error(X_new, input.X_WH, e.dtheta);
    const BentObstacles bent(input.obstacles, moved(state.holds, step));
    const double credit = curvature_credit(input, w, result, X_new, bent.view(), fraction);
    const double gain = string_energy_gain(input, state, w.models, step);
    const int samples = 2 + static_cast<int>(fraction * samples_of_full_step);
    if (coupling_energy(input.stiffness, e_new) + gain - credit <= energy + rounding &&
        clear_of_contacts(input, state, w, step, samples, result)) {
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
  query(input, state, wanted, w, result);
  if (w.contacts.minimum_gap < 0.0 && !w.leaves) {
    // An overlap of bounds is none of the tool; to push it out of them could push a leaf in.
    w.leaves = true;
    query(input, state, wanted, w, result);
  }
}

bool advance_sub_step(const OptimiserInput& input, OptimiserState& state, OptimiserWorkspace& w,
                      OptimiserResult& result) noexcept {
  ++result.sub_steps;
  const ToolStep e = coupling_error(state.X_WG, input.X_WH, state.phi_GH_W);
  state.phi_GH_W = e.dtheta;
  const double wanted = displacement_bound(e, reach(input.tool));
  refresh(input, state, wanted, w, result);

  if (wanted + greatest_deflection(state.holds) <= w.contacts.minimum_gap - input.options.skin) {
    commit_free(input, e, state, w, result);
    return false;
  }
  if (!input.strings.empty() && update_holds(string_context(input), w.contacts, input.options.skin,
                                             state.holds, result.strings_refused)) {
    query(input, state, wanted, w, result);
  }

  const double holds = solve_linearisation(input, state, e, w, result);
  if (w.solution.status != QpStatus::kOptimal) {
    keep_after_failure(input, e, state, result);
    return false;
  }
  take_force(input, state, w, result);
  const bool converged = step_bound(input, state, w.step) < input.options.stop_tolerance;
  const double fraction = std::min(holds, step_fraction(input, state, w));
  const bool moved_on = commit_admissible(input, e, fraction, state, w, result);
  result.status = converged  ? OptimiserStatus::kConverged
                  : moved_on ? OptimiserStatus::kLagging
                             : OptimiserStatus::kRefused;
  return !converged && moved_on;
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
  if (w.contacts.minimum_gap < 0.0) {
    recover(input, state, w, result);
    return;
  }
  while (result.sub_steps < input.options.sub_steps && advance_sub_step(input, state, w, result)) {
  }
  finish_tick(input, state);
}

}  // namespace hapticd
