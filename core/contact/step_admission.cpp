// The step's length, its exact check and its energy. See step_admission.h. RT: yes.
#include "core/contact/step_admission.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "core/collision/blend_steepness.h"
#include "core/contact/coupling_axes.h"

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
/// A blended surface that is less steep than this counts as so steep: hardly any is, but between
/// leaves that face each other. Smaller: more of what hollows take counts as pressing.
constexpr double kLeastSteepness = 0.25;
/// Turn of a leg that counts as any turn, rad.
constexpr double kMaxLegTurn = 2.0;

/// Largest fraction of the full step that keeps the linearisation valid: no tool point moves
/// further than the pairs not in the program allow.
double step_fraction(const ContactView& view, const WantedStep& wanted) noexcept {
  const ConfigurationStep& step = wanted.program.step();
  const double displacement = step_bound(view.at(), step);
  const bool nothing_near = view.contacts.contacts.empty();
  const double cap =
      nothing_near ? view.contacts.minimum_gap - view.state.clearance : wanted.room_left;
  double fraction = displacement > cap ? cap / displacement : 1.0;
  const double angle = step.tool.dtheta.norm();
  if (!nothing_near && angle * fraction > view.input.options.rotation_step) {
    fraction = view.input.options.rotation_step / angle;
  }
  return fraction;
}

/// Smallest distance from a string's axis to the centre of a tool sphere that touches it, m.
double smallest_distance(const ContactView& view, std::int32_t capsule) noexcept {
  double smallest = std::numeric_limits<double>::infinity();
  const double R = view.input.obstacles.capsules_W[static_cast<std::size_t>(capsule)].r;
  for (const Contact& contact : view.contacts.contacts) {
    if (!is_string(contact.key) || contact.key.obstacle != capsule) continue;
    smallest = std::min(smallest, R + tree_sphere(view.input.tool, contact.key.tool_sphere).r);
  }
  return smallest;
}

/// A leg of a string that moves.
struct LegMotion {
  double from;    ///< its length, m
  double to;      ///< after the step
  double turned;  ///< travel of its vertex, m
};

/// How near a tool may come to a point of the string's leg on its way, unseen by the rows, m: they
/// keep it out of the point that is nearest at the start, and of what is convex and goes straight.
/// Where the leg turns by phi the nearest point slides along it, by up to phi (d + travel) or the
/// leg's length, and other points of the leg move differently.
double unseen_approach(const LegMotion& leg, double travel, double d) noexcept {
  const double shorter = std::min(leg.from, leg.to);
  const double longer = std::max(leg.from, leg.to);
  const double phi = leg.turned < kMaxLegTurn * shorter ? leg.turned / shorter : kMaxLegTurn;
  const double slide = std::min(longer, phi * (d + travel));
  const double apart = leg.turned * (slide / longer);
  const double lean = slide + apart * (d / travel);
  return lean * lean / (2.0 * d);
}

/// Smallest distance between the centres of a tool sphere and a leaf of the blended surface that it
/// is near to, m; infinite where there is none.
double smallest_leaf_distance(const ContactView& view) noexcept {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Contact& contact : view.contacts.contacts) {
    if (!is_blend(contact.key)) continue;
    const BodyView& body =
        view.input.obstacles.bodies[static_cast<std::size_t>(contact.key.obstacle)];
    smallest = std::min(smallest, body.tree.blend.least_radius +
                                      tree_sphere(view.input.tool, contact.key.tool_sphere).r);
  }
  return std::max(smallest, kPathError);
}

/// How many places of the step have to be looked at so that no more than kPathError hides between
/// them: n places leave the sagitta (travel / n)^2 / (8 d) of a way past a point, and that of
/// rotation.
double path_samples(const ContactView& view, const ConfigurationStep& step) noexcept {
  const auto& [input, state] = view.at();
  const double reach_of_tool = tool_reach(view.at());
  const double parts = SoftParts::travel(view.at(), step);
  const double angle = step.tool.dtheta.norm();
  double error = 0.125 * step.tool.dtheta.squaredNorm() * (reach_of_tool + parts);
  error += 0.25 * angle * parts;
  // Rows keep a tool out of the blend where it is; out of the leaves next to that, the look does.
  const double way = displacement_bound(step.tool, reach_of_tool + parts) + parts;
  error = std::max(error, 0.125 * way * way / smallest_leaf_distance(view));
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    const TouchedString& string = state.touched[k];
    const StringMotion& motion = step.strings[k];
    const double length = input.strings[static_cast<std::size_t>(string.bend.capsule)].length;
    const double turned = displacement_bound(motion, length);
    if (!string.yields || !(turned > 0.0)) continue;
    const double d = smallest_distance(view, string.bend.capsule);
    const double travel = displacement_bound(step.tool, reach_of_tool + parts) + parts + turned;
    const double u_from = string.bend.u_W.norm();
    const StringBend end = moved(string.bend, motion);
    const double u_to = end.u_W.norm();
    for (const bool first : {true, false}) {
      const double from = u_from + length * (first ? string.bend.lambda : 1.0 - string.bend.lambda);
      const double to = u_to + length * (first ? end.lambda : 1.0 - end.lambda);
      if (unseen_approach({from, to, turned}, travel, d) > kPathError) {
        error = std::max(error, 0.125 * travel * travel / d);
      }
    }
  }
  return std::sqrt(error / kPathError);
}

/// What a step does to gaps at most, to see without evaluating them which pairs it cannot close.
struct GapBound {
  const ContactState& state;
  const ConfigurationStep& step;
  double displacement;  ///< of any point, m
  double turning;       ///< by which rotation leaves its tangent, m
  double room;          ///< for rounding, m

  /// False when the pair's gap certainly stays open all along the step. No gap changes by more than
  /// the displacement. The distance from what is
  /// convex and stands still is a convex function of the centre's place, hence no less than its
  /// tangent; along the step that is gap + s n . (dp + dtheta x a) - s^2 |dtheta|^2 |a| / 2, least
  /// at an end.
  [[nodiscard]] bool may_close(const Contact& contact) const noexcept {
    if (contact.gap > displacement) return false;
    if (!state.parts.empty() || is_blend(contact.key)) return true;
    if (const int string = find_touched(state.touched, contact.key);
        string >= 0 && state.touched[static_cast<std::size_t>(string)].yields) {
      return true;
    }
    const Vector3 a = contact.p_WC - state.X_WG.p;
    const double along = contact.nhat_OG_W.dot(step.tool.dp + step.tool.dtheta.cross(a));
    return !(contact.gap > room && contact.gap + along - turning > room);
  }
};

GapBound gap_bound(const Configuration& at, const ConfigurationStep& step) noexcept {
  const double reach_of_tool = tool_reach(at);
  return {at.state, step, step_bound(at, step),
          0.5 * step.tool.dtheta.squaredNorm() * reach_of_tool,
          kGapRounding + kRelativeRounding * (at.state.X_WG.p.norm() + reach_of_tool)};
}

/// Exact gaps of every pair that the step could close, at its end and at `samples` - 1 places
/// before.
bool clear_of_contacts(const ContactView& view, const ConfigurationStep& step, int samples,
                       ContactResult& result) noexcept {
  const auto& [input, state] = view.at();
  const GapBound bound = gap_bound(view.at(), step);
  std::array<std::int32_t, kMaxCandidates> critical;
  std::size_t count = 0;
  for (std::size_t c = 0; c < view.contacts.contacts.size(); ++c) {
    if (bound.may_close(view.contacts.contacts[c])) {
      critical[count++] = static_cast<std::int32_t>(c);
    }
  }
  for (int k = samples; k > 0; --k) {
    const double part = static_cast<double>(k) / samples;
    const Pose X = moved(state.X_WG, scaled(step.tool, part));
    const BentObstacles bent(input.obstacles, state.touched, step.strings, part);
    const ToolShape shape(input.parts, state.parts, step.parts, part);
    result.tests += static_cast<std::int64_t>(count);
    result.evaluations += static_cast<std::int64_t>(count);
    if (any_gap_below(-input.rounding, {view.contacts, std::span(critical).first(count)},
                      {input.tool, X, shape.view()}, bent.view())) {
      return false;
    }
  }
  return true;
}

/// The way along the normal by which a gap grows by `gained`.
double way_of(double gained, const ContactKey& key, const ToolView& tool,
              const ObstaclesView& obstacles) noexcept {
  if (!is_blend(key)) return gained;
  return gained / std::max(kLeastSteepness, blend_steepness(key, tool, obstacles));
}

/// Energy that a step may take: what pressing back onto the obstacles will release once more,
/// multiplier times what each touched gap has gained over its linear prediction (without it every
/// long step along a curved obstacle would look like a climb: the Maratos effect), and what it
/// costs to win skin back.
double energy_credit(const ContactView& view, const RowProgram& program,
                     const Admission& end) noexcept {
  const auto& [input, state] = view.at();
  const BentObstacles bent(input.obstacles, state.touched, end.step.strings, 1.0);
  const ToolShape shape(input.parts, state.parts, end.step.parts, 1.0);
  const ObstaclesView obstacles = bent.view();
  const DisplacedParts displaced = shape.view();
  double credit = 0.0;
  for (int k = 0; k < view.result.active_count; ++k) {
    const ActiveContact& active = view.result.active[static_cast<std::size_t>(k)];
    const Contact& contact = view.contact_of(active);
    const double wanted = end.fraction * program.wanted_gain(k);
    const ToolView tool{input.tool, end.X_WG, displaced};
    const double gained = evaluate_contact(contact.key, tool, obstacles).gap - contact.gap;
    credit += active.multiplier * (way_of(gained, contact.key, tool, obstacles) - wanted);
    // Not the multiplier that bound_force left: the program's own is what the way out costs.
    credit += program.active(k).multiplier * std::max(0.0, wanted);
  }
  return credit;
}

/// `fraction` of the full step of a linearisation, with or without the way to the centres.
void scale_step(const ContactState& state, const ConfigurationStep& full, Admission& out) noexcept {
  out.step.tool = scaled(full.tool, out.fraction);
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    StringMotion motion = full.strings[k];
    if (!out.centred && motion.centring != 0.0) {
      motion.dlambda -= motion.centring;
      motion.centring = 0.0;
    }
    out.step.strings[k] = scaled(motion, out.fraction);
  }
  for (std::size_t k = 0; k < state.parts.size(); ++k) {
    const PartMotion& motion = full.parts[k];
    out.step.parts[k] = {motion.dv_W * out.fraction, motion.dv_G * out.fraction};
  }
}

bool any_centring(const ContactState& state, const ConfigurationStep& step) noexcept {
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    if (step.strings[k].centring != 0.0) return true;
  }
  return false;
}

/// By how much an energy that strings and parts have a share in may seem to climb, J.
double energy_rounding(const ContactView& view, double energy) noexcept {
  const ContactState& state = view.state;
  double rounding = state.touched.empty() && state.parts.empty() ? 0.0 : kEnergyRounding * energy;
  for (std::size_t k = 0; k < state.parts.size(); ++k) {
    const PartBlock& part = view.parts.block(k);
    rounding += kEnergyRounding * part.stiffness * part.off_G.squaredNorm();
  }
  return rounding;
}

}  // namespace

double step_bound(const Configuration& at, const ConfigurationStep& step) noexcept {
  const double strings = YieldingStrings::travel(at, step);
  const double parts = SoftParts::travel(at, step);
  return displacement_bound(step.tool, tool_reach(at) + parts) + strings + parts;
}

void admissible_fraction(const ContactView& view, const WantedStep& wanted, Admission& admission,
                         ContactResult& result) noexcept {
  const CouplingStiffness& stiffness = view.input.stiffness;
  const ConfigurationStep& full = wanted.program.step();
  double& fraction = admission.fraction;
  fraction = std::min(wanted.program.feasible_fraction(), step_fraction(view, wanted));
  const Quaternion& q_WH = view.input.X_WH.q;
  const double energy = coupling_energy(stiffness, q_WH, wanted.error_GH);
  const double rounding = energy_rounding(view, energy);
  const double samples_of_full_step = path_samples(view, full);
  if (fraction * samples_of_full_step > kMaxPathSamples) {
    fraction = kMaxPathSamples / samples_of_full_step;
  }
  const int halvings = wanted.last ? 0 : kMaxHalvings;
  for (int halving = 0; halving <= halvings; ++halving) {
    scale_step(view.state, full, admission);
    const ConfigurationStep& step = admission.step;
    admission.X_WG = moved(view.state.X_WG, step.tool);
    const PoseError error_GH =
        coupling_error(admission.X_WG, view.input.X_WH, wanted.error_GH.dtheta);
    const double credit = energy_credit(view, wanted.program, admission);
    const double gain = view.strings.energy_gain(view.at(), step) +
                        view.parts.energy_gain(view.at(), step) +
                        view.friction.energy_gain(view.at(), step);
    const int samples = 2 + static_cast<int>(fraction * samples_of_full_step);
    if (coupling_energy(stiffness, q_WH, error_GH) + gain - credit <= energy + rounding &&
        clear_of_contacts(view, step, samples, result) &&
        YieldingStrings::clear_of_others(view.at(), step)) {
      admission.phi_GH_W = error_GH.dtheta;
      admission.admitted = true;
      return;
    }
    ++result.halvings;
    if (admission.centred && any_centring(view.state, full)) {
      admission.centred = false;
    } else {
      fraction *= 0.5;
    }
  }
}

}  // namespace hapticd
