// The step's length, its exact check and its energy. See step_admission.h. RT: yes.
#include "core/contact/step_admission.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/contact/string_block.h"

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
constexpr double kPathError = 0.25e-6;
/// Places looked at in a step, at most; a step that needs more is shortened.
constexpr double kMaxPathSamples = 16.0;
/// A pair is left out of the exact look where a bound keeps its gap above this, m, and this share
/// of the lengths at hand: far above the rounding of bound and gap (1e-15 of them), far below the
/// skin. Larger: more pairs are looked at.
constexpr double kGapRounding = 1e-9;
constexpr double kRelativeRounding = 1e-12;
/// Turn of a leg that counts as any turn, rad.
constexpr double kMaxLegTurn = 2.0;

/// Greatest motion of a soft part against the rigid tool in `step`, m.
double greatest_motion(const ContactState& state, const ConfigurationStep& step) noexcept {
  double greatest = 0.0;
  for (std::size_t k = 0; k < state.parts.size(); ++k) {
    greatest = std::max(greatest, step.parts[k].dv_G.norm());
  }
  return greatest;
}

/// Largest fraction of the full step that keeps the linearisation valid: no tool point moves
/// further than the pairs not in the program allow.
double step_fraction(const ContactInput& input, const ContactState& state,
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
double smallest_distance(const ContactInput& input, const ContactSet& contacts,
                         std::int32_t capsule) noexcept {
  double smallest = std::numeric_limits<double>::infinity();
  const double R = input.obstacles.capsules_W[static_cast<std::size_t>(capsule)].r;
  for (const Contact& contact : contacts.contacts) {
    if (contact.key.kind != ObstacleKind::kCapsule || contact.key.obstacle != capsule) continue;
    smallest = std::min(smallest, R + tree_sphere(input.tool, contact.key.tool_sphere).r);
  }
  return smallest;
}

/// How near a tool may come to a point of the string's leg on its way, unseen by the rows, m: they
/// keep it out of the point that is nearest at the start, and of what is convex and goes straight.
/// Where the leg turns by phi the nearest point slides along it, by up to phi (d + way) or the
/// leg's length, and other points of the leg move differently.
double unseen_approach(double from, double to, double turned, double way, double d) noexcept {
  const double shorter = std::min(from, to);
  const double longer = std::max(from, to);
  const double phi = turned < kMaxLegTurn * shorter ? turned / shorter : kMaxLegTurn;
  const double slide = std::min(longer, phi * (d + way));
  const double apart = turned * (slide / longer);
  const double lean = slide + apart * (d / way);
  return lean * lean / (2.0 * d);
}

/// How many places of the step have to be looked at so that no more than kPathError hides between
/// them: n places leave the sagitta (way / n)^2 / (8 d) of a way past a point, and that of
/// rotation.
double path_samples(const ContactInput& input, const ContactState& state,
                    const OptimiserWorkspace& w, const ConfigurationStep& step) noexcept {
  const double reach_of_tool = tool_reach(input.tool, state);
  const double parts = greatest_motion(state, step);
  const double angle = step.tool.dtheta.norm();
  double error = 0.125 * step.tool.dtheta.squaredNorm() * (reach_of_tool + parts);
  error += 0.25 * angle * parts;
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    const TouchedString& hold = state.touched[k];
    const StringMotion& motion = step.strings[k];
    const double length = input.strings[static_cast<std::size_t>(hold.bend.capsule)].length;
    const double turned = displacement_bound(motion, length);
    if (!hold.yields || !(turned > 0.0)) continue;
    const double d = smallest_distance(input, w.contacts, hold.bend.capsule);
    const double way = displacement_bound(step.tool, reach_of_tool + parts) + parts + turned;
    const double u_from = hold.bend.u_W.norm();
    const StringBend end = moved(hold.bend, motion);
    const double u_to = end.u_W.norm();
    for (const bool first : {true, false}) {
      const double from = u_from + length * (first ? hold.bend.lambda : 1.0 - hold.bend.lambda);
      const double to = u_to + length * (first ? end.lambda : 1.0 - end.lambda);
      if (unseen_approach(from, to, turned, way, d) > kPathError) {
        error = std::max(error, 0.125 * way * way / d);
      }
    }
  }
  return std::sqrt(error / kPathError);
}

/// What a step does to gaps at most, to see without evaluating them which pairs it cannot close.
struct GapBound {
  const ContactInput& input;
  const ContactState& state;
  const ConfigurationStep& step;
  double displacement;  ///< of any point, m
  double turning;       ///< by which rotation leaves its tangent, m
  double room;          ///< for rounding, m

  /// False when the pair's gap certainly stays open all along the step. The distance from what is
  /// convex and stands still is a convex function of the centre's place, hence no less than its
  /// tangent; along the step that is gap + s n . (dp + dtheta x a) - s^2 |dtheta|^2 |a| / 2, least
  /// at an end.
  [[nodiscard]] bool may_close(const Contact& contact) const noexcept {
    if (contact.gap > displacement) return false;
    if (!state.parts.empty()) return true;
    if (const int hold = find_touched(state.touched, contact.key);
        hold >= 0 && state.touched[static_cast<std::size_t>(hold)].yields) {
      return true;
    }
    const Vector3 a = contact.p_WC - state.X_WG.p;
    const double along = contact.nhat_OG_W.dot(step.tool.dp + step.tool.dtheta.cross(a));
    return !(contact.gap > room && contact.gap + along - turning > room);
  }
};

GapBound gap_bound(const ContactInput& input, const ContactState& state,
                   const ConfigurationStep& step) noexcept {
  const double reach_of_tool = tool_reach(input.tool, state);
  return {input,
          state,
          step,
          step_bound(input, state, step),
          0.5 * step.tool.dtheta.squaredNorm() * reach_of_tool,
          kGapRounding + kRelativeRounding * (state.X_WG.p.norm() + reach_of_tool)};
}

/// Exact gaps of every pair that the step could close, at its end and at `samples` - 1 places
/// before.
bool clear_of_contacts(const ContactInput& input, const ContactState& state,
                       const OptimiserWorkspace& w, const ConfigurationStep& step, int samples,
                       ContactResult& result) noexcept {
  const GapBound bound = gap_bound(input, state, step);
  std::array<std::int32_t, kMaxCandidates> critical;
  std::size_t count = 0;
  for (std::size_t c = 0; c < w.contacts.contacts.size(); ++c) {
    if (bound.may_close(w.contacts.contacts[c])) critical[count++] = static_cast<std::int32_t>(c);
  }
  for (int k = samples; k > 0; --k) {
    const double part = static_cast<double>(k) / samples;
    const Pose X = moved(state.X_WG, scaled(step.tool, part));
    const BentObstacles bent(input.obstacles, state.touched, step, part);
    const ToolShape shape(input.parts, state.parts, step.parts, part);
    result.tests += static_cast<std::int64_t>(count);
    result.evaluations += static_cast<std::int64_t>(count);
    if (any_gap_below(-input.rounding, std::span(critical).first(count), w.contacts, input.tool, X,
                      bent.view(), shape.view())) {
      return false;
    }
  }
  return true;
}

/// No string is moved into another tool.
bool clear_of_others(const ContactInput& input, const ContactState& state,
                     const ConfigurationStep& step) noexcept {
  if (input.others.tools.empty()) return true;
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    const TouchedString& hold = state.touched[k];
    if (!hold.yields) continue;
    const auto index = static_cast<std::size_t>(hold.bend.capsule);
    if (!clear_of_other_tools(input.others, input.obstacles.capsules_W[index], hold.bend,
                              step.strings[k])) {
      return false;
    }
  }
  return true;
}

/// Where a step leads.
struct Configuration {
  const Pose& X_WG;
  const ObstaclesView& obstacles;
  const DisplacedParts& displaced;
};

/// Energy that a step may take: what pressing back onto the obstacles will release once more,
/// multiplier times what each touched gap has gained over its linear prediction (without it every
/// long step along a curved obstacle would look like a climb: the Maratos effect), and what it
/// costs to win skin back.
double energy_credit(const ContactInput& input, const OptimiserWorkspace& w,
                     const ContactResult& result, const Configuration& end,
                     double fraction) noexcept {
  double credit = 0.0;
  for (int k = 0; k < result.active_count; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const ActiveContact& active = result.active[i];
    const Contact& contact = w.contacts.contacts[static_cast<std::size_t>(active.contact)];
    const double wanted =
        fraction * w.problem.bound[static_cast<std::size_t>(w.solution.active[i])];
    const Contact there =
        evaluate_contact(contact.key, input.tool, end.X_WG, end.obstacles, end.displaced);
    credit += active.multiplier * (there.gap - (contact.gap + wanted));
    // Not the multiplier that bound_forces left: the program's own is what the way out costs.
    credit += w.solution.multiplier[i] * std::max(0.0, wanted);
  }
  return credit;
}

/// What the held strings gain in energy over `step`: elastic at the new place of the vertex (a
/// string gives no force along its axis unless asked to, so what sliding changes is no work), and
/// friction.
double string_energy_gain(const ContactInput& input, const ContactState& state,
                          const StringBlocks& models, const ConfigurationStep& step) noexcept {
  double gain = 0.0;
  const StringContext context = string_context(input);
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    const TouchedString& hold = state.touched[k];
    const StringMotion& motion = step.strings[k];
    if (hold.yields) {
      const StringBend end = moved(hold.bend, motion);
      StringBend start = end;
      start.u_W = hold.bend.u_W;
      gain += string_law(context, end, end.u_W.norm()).energy -
              string_law(context, start, start.u_W.norm()).energy;
      double slid = step.tool.dp.dot(models[k].axis_W) +
                    step.tool.dtheta.cross(models[k].p_GC_W).dot(models[k].axis_W);
      for (std::size_t p = 0; p < models[k].parts; ++p) {
        slid += models[k].part_share[p] * step.parts[p].dv_W.dot(models[k].axis_W);
      }
      gain -= models[k].lateral_force * slid;
    }
    if (models[k].slip_stiffness > 0.0) {
      const auto index = static_cast<std::size_t>(hold.bend.capsule);
      const double limit = input.strings[index].friction_coefficient * hold.normal_force;
      const Vector3 slip = models[k].slip_W + slip_motion(models[k], hold.bend, step, motion.du_W);
      const double stiffness = input.instrument.anchor_stiffness;
      gain += slip_energy(stiffness, limit, slip.norm()) -
              slip_energy(stiffness, limit, models[k].slip_W.norm());
    }
  }
  return gain;
}

void commit(const ContactInput& input, const ConfigurationStep& step, const Pose& X_new,
            ContactState& state, OptimiserWorkspace& w) noexcept {
  const double way = step_bound(input, state, step);
  w.travelled += way;
  state.travel += way;
  w.stale = true;
  state.X_WG = X_new;
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    TouchedString& hold = state.touched[k];
    if (input.instrument.friction && w.models[k].touched) {
      hold.slip_W =
          w.models[k].slip_W + slip_motion(w.models[k], hold.bend, step, step.strings[k].du_W);
    }
    hold.bend = moved(hold.bend, step.strings[k]);
  }
  for (std::size_t k = 0; k < state.parts.size(); ++k) state.parts[k].v_G += step.parts[k].dv_G;
}

/// What the soft parts gain in energy over `step`.
double part_energy_gain(const ContactState& state, const PartBlocks& models,
                        const ConfigurationStep& step) noexcept {
  double gain = 0.0;
  for (std::size_t k = 0; k < state.parts.size(); ++k) {
    gain += part_energy_gain(models[k], step.parts[k]);
  }
  return gain;
}

/// `fraction` of the full step of a linearisation.
ConfigurationStep scaled(const ContactState& state, const ConfigurationStep& full,
                         double fraction) noexcept {
  ConfigurationStep step;
  step.tool = scaled(full.tool, fraction);
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    step.strings[k] = scaled(full.strings[k], fraction);
  }
  for (std::size_t k = 0; k < state.parts.size(); ++k) {
    step.parts[k] = {full.parts[k].dv_W * fraction, full.parts[k].dv_G * fraction};
  }
  return step;
}

/// Leaves out of the full step what only takes vertices to the centres of their contacts, which a
/// contact on either side may forbid. True when there was such.
bool drop_centring(std::size_t holds, ConfigurationStep& full) noexcept {
  bool dropped = false;
  for (std::size_t k = 0; k < holds; ++k) {
    StringMotion& motion = full.strings[k];
    if (motion.centring == 0.0) continue;
    dropped = true;
    motion.dlambda -= motion.centring;
    motion.centring = 0.0;
  }
  return dropped;
}

}  // namespace

double step_bound(const ContactInput& input, const ContactState& state,
                  const ConfigurationStep& step) noexcept {
  double strings = 0.0;
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    const auto index = static_cast<std::size_t>(state.touched[k].bend.capsule);
    strings = std::max(strings, displacement_bound(step.strings[k], input.strings[index].length));
  }
  const double parts = greatest_motion(state, step);
  return displacement_bound(step.tool, tool_reach(input.tool, state) + parts) + strings + parts;
}

bool commit_admissible(const ContactInput& input, const PoseError& error_GH, double holds,
                       bool last, ContactState& state, OptimiserWorkspace& w,
                       ContactResult& result) noexcept {
  double fraction = std::min(holds, step_fraction(input, state, w));
  const double energy = coupling_energy(input.stiffness, error_GH);
  double rounding = state.touched.empty() && state.parts.empty() ? 0.0 : kEnergyRounding * energy;
  for (std::size_t k = 0; k < state.parts.size(); ++k) {
    rounding += kEnergyRounding * w.parts[k].stiffness * w.parts[k].off_G.squaredNorm();
  }
  const double samples_of_full_step = path_samples(input, state, w, w.step);
  if (fraction * samples_of_full_step > kMaxPathSamples) {
    fraction = kMaxPathSamples / samples_of_full_step;
  }
  const int halvings = last ? 0 : kMaxHalvings;
  for (int halving = 0; halving <= halvings; ++halving) {
    const ConfigurationStep step = scaled(state, w.step, fraction);
    const Pose X_new = moved(state.X_WG, step.tool);
    const PoseError error_new = coupling_error(X_new, input.X_WH, error_GH.dtheta);
    const BentObstacles bent(input.obstacles, state.touched, step, 1.0);
    const ToolShape shape(input.parts, state.parts, step.parts, 1.0);
    const double credit =
        energy_credit(input, w, result, {X_new, bent.view(), shape.view()}, fraction);
    const double gain =
        string_energy_gain(input, state, w.models, step) + part_energy_gain(state, w.parts, step);
    const int samples = 2 + static_cast<int>(fraction * samples_of_full_step);
    if (coupling_energy(input.stiffness, error_new) + gain - credit <= energy + rounding &&
        clear_of_contacts(input, state, w, step, samples, result) &&
        clear_of_others(input, state, step)) {
      commit(input, step, X_new, state, w);
      w.full_step = fraction == 1.0;
      state.phi_GH_W = error_new.dtheta;
      return true;
    }
    ++result.halvings;
    if (!drop_centring(state.touched.size(), w.step)) fraction *= 0.5;
  }
  return false;
}

}  // namespace hapticd
