// The loop of one tick: query, linearise, solve, step, exact re-check, commit. See
// contact_problem.h. RT: yes.
#include "core/contact/contact_problem.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/contact/clearance.h"
#include "core/contact/coupling_axes.h"
#include "core/contact/phantom_contacts.h"
#include "core/contact/recovery.h"
#include "core/contact/stationarity.h"
#include "core/contact/step_admission.h"
#include "core/contact/tick_work.h"
#include "core/math/assert.h"

namespace hapticd {
namespace {

/// Share by which the energy of a force may exceed all that is stored before the force is shrunk: a
/// tool at rest comes within rounding of it. Larger: a spike of half of it passes.
constexpr double kEnergySlack = 0.01;
/// By what share of the last one, 1 in so many, the next linearisation may be dearer. Larger: more
/// ticks go beyond their work budget.
constexpr std::int64_t kDearerNext = 8;
/// The least that tools keep off a string that they share, m. Less: none of them could move it, for
/// a string comes no nearer to another tool than kOtherToolClearance.
constexpr double kLeastSharedClearance = 2.0 * kOtherToolClearance;

/// How far any point of the tool goes relative to any of a string when nothing holds either back,
/// m.
double free_travel(const Configuration& at, const PoseError& error_GH) noexcept {
  const double parts = SoftParts::free_travel(at);
  return displacement_bound(closing(error_GH), tool_reach(at) + parts) + parts +
         greatest_deflection(at.state.touched);
}

/// What a tool keeps off strings that others hold too, m: a string gives way to another tool by no
/// more than what that one keeps off it. 0: it touches none of them.
double shared_clearance(const ContactInput& input, const ContactSet& contacts) noexcept {
  const double near = kTouchSkins * skin_of(input.options);
  const auto is_shared = [&](const Contact& contact) {
    const auto index = static_cast<std::size_t>(contact.key.obstacle);
    return is_string(contact.key) && contact.gap <= near && index < input.strings.size() &&
           input.strings[index].shared;
  };
  if (input.others.tools.empty() ||
      std::none_of(contacts.contacts.begin(), contacts.contacts.end(), is_shared)) {
    return 0.0;
  }
  double most = kLeastSharedClearance;
  for (const OtherTool& other : input.others.tools) most = std::max(most, other.clearance);
  return std::min(most, skin_of(input.options));
}

/// What a string bears of a pair beside the part that yields.
void add_beside(const ContactInput& input, const ContactState& state, const ActivePair& pair,
                std::span<StringSum> sums) noexcept {
  if (input.rigid_parts.empty() || !is_string(pair.key)) return;
  const int k = find_touched(state.touched, string_of_part(input, pair.key.obstacle));
  if (k >= 0) sums[static_cast<std::size_t>(k)].beside += pair.multiplier;
}

}  // namespace

// The free way: G reaches H, all strings are at rest, soft parts go there as their dampers let
// them.
void ContactProblem::commit_free(double travel) noexcept {
  ContactState& state = *state_;
  solved_ = Solved::kNothing;
  candidates_.moved(travel);
  state.travel += travel;
  state.X_WG = input_->X_WH;
  YieldingStrings::relax(*input_, state.touched);
  if (!state.grips.empty()) state.grips.clear();
  SoftParts::relax(*input_, state.parts);
  state.phi_GH_W = Vector3::Zero();
  state.F_H_W = Wrench{};
  state.active_count = 0;
  result_->F_H_W = Wrench{};
  result_->active_count = 0;
  result_->status = ContactStatus::kFree;
}

// Shrinks forces that all springs together cannot give: none may press the tool harder than letting
// all their energy go into the coupling. At rest forces are what the coupling's is and far below;
// the multipliers of a program far from rest, on tightly turning contacts, know no bound.
void ContactProblem::bound_force(const PoseError& error_GH) noexcept {
  ContactState& state = *state_;
  const CouplingStiffness& stiffness = input_->stiffness;
  Wrench& F_H_W = state.F_H_W;
  const Quaternion& q_WH = input_->X_WH.q;
  const double given = energy_under(stiffness, q_WH, error_GH, F_H_W);
  double stored = coupling_energy(stiffness, q_WH, error_GH);
  if (given <= (1.0 + kEnergySlack) * stored) return;
  strings_.add_stored_energy(at(), stored);
  parts_.add_stored_energy(at(), stored);
  friction_.add_stored_energy(at(), stored);
  if (given <= (1.0 + kEnergySlack) * stored) return;
  const double factor = std::sqrt(stored / given);
  F_H_W = {F_H_W.f * factor, F_H_W.t * factor};
  for (int k = 0; k < result_->active_count; ++k) {
    result_->active[static_cast<std::size_t>(k)].multiplier *= factor;
    state.active[static_cast<std::size_t>(k)].multiplier *= factor;
  }
  for (TouchedString& string : state.touched) {
    string.normal_force *= factor;
    string.tangential_W *= factor;
  }
}

// Force and active pairs from the multipliers of the full-target program. Zero when the tool only
// lags in free space, where the spring between G and H would render a phantom.
void ContactProblem::take_force(const PoseError& error_GH) noexcept {
  ContactState& state = *state_;
  ContactResult& result = *result_;
  state.F_H_W = Wrench{};
  result.active_count = 0;
  state.active_count = 0;
  std::array<StringSum, kMaxDeflectingStrings> sums;
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    sums[k] = {Vector3::Zero(), 0.0, 0.0, 0.0};
  }
  for (int k = 0; k < program_.active_count(); ++k) {
    const ActiveContact active = program_.active(k);
    const double multiplier = active.multiplier;
    const Contact& contact =
        candidates_.contacts().contacts[static_cast<std::size_t>(active.contact)];
    const GapGradient gradient = strings_.gradient(state, contact);
    const Vector3 f = multiplier * gradient.linear;
    state.F_H_W.f += f;
    state.F_H_W.t += multiplier * gradient.angular;
    result.active[static_cast<std::size_t>(result.active_count++)] = active;
    state.active[static_cast<std::size_t>(state.active_count++)] = {contact.key, multiplier};
    if (gradient.string < 0) {
      add_beside(*input_, state, {contact.key, multiplier}, sums);
      continue;
    }
    StringSum& sum = sums[static_cast<std::size_t>(gradient.string)];
    sum.f_W += f;
    sum.lambda += multiplier * contact.lambda;
    sum.multiplier += multiplier;
  }
  strings_.settle(*input_, sums, program_.step(), state);
  friction_.settle(*input_, candidates_.contacts(), result, program_.step(), state);
  bound_force(error_GH);
  result.F_H_W = state.F_H_W;
}

// The solver's iterates are infeasible until the last, so without an optimum G stays and the force
// may only shrink.
void ContactProblem::keep_after_failure(const PoseError& error_GH) noexcept {
  ContactState& state = *state_;
  const CouplingStiffness& stiffness = input_->stiffness;
  const double limit = stiffness.per_axis ? stiffness.along_W().cwiseProduct(error_GH.dp).norm()
                                          : stiffness.kt * error_GH.dp.norm();
  const double before = state.F_H_W.f.norm();
  // Of numbers that are none the force is none either, which ends in a fault.
  const double factor = before <= limit ? 1.0 : limit / before;
  state.F_H_W = {state.F_H_W.f * factor, state.F_H_W.t * factor};
  result_->F_H_W = state.F_H_W;
  result_->active_count = 0;
  result_->status = ContactStatus::kQpFailed;
}

// Takes up and lets go of soft parts and strings, which moves nothing.
void ContactProblem::touch(double wanted) noexcept {
  const ContactSet& contacts = candidates_.contacts();
  if (!input_->parts.parts.empty() &&
      SoftParts::touch(*input_, contacts, state_->parts, result_->parts_refused)) {
    full_step_ = false;
  }
  if (!input_->strings.empty() &&
      YieldingStrings::touch(*input_, contacts, state_->touched, result_->strings_refused)) {
    candidates_.query(at(), wanted, *result_);
  }
}

void ContactProblem::begin(const ContactInput& input, ContactState& state,
                           ContactResult& result) noexcept {
  input_ = &input;
  state_ = &state;
  result_ = &result;
  static_cast<ContactSummary&>(result) = ContactSummary{};
  SoftParts::begin(input, state.parts);
  const PoseError error_GH = coupling_error(state.X_WG, input.X_WH, state.phi_GH_W);
  const double wanted = displacement_bound(closing(error_GH), tool_reach(at()));
  const ToolMotion hand = motion_between(state.X_WH, input.X_WH);
  const double hand_travel = displacement_bound(hand, tool_reach(at()));
  const double pace = std::max(state.travel, hand_travel);
  state.clearance = clearance_for(input.options, state.clearance, hand_travel);
  state.X_WH = input.X_WH;
  state.travel = 0.0;
  pressed_before_.clear();
  for (int k = 0; k < state.active_count; ++k) {
    pressed_before_.push_back(state.active[static_cast<std::size_t>(k)].key);
  }
  if (state.active_count == 0) {
    state.tool_level = input.options.tool_level;
    state.body_level = input.options.body_level;
  }
  const bool leaves =
      (state.tool_level == kLeafLevel && state.body_level == kLeafLevel) || any_soft(input.parts);
  full_step_ = false;
  solved_ = Solved::kNothing;
  candidates_.begin(pace, leaves);
  candidates_.query(at(), wanted, result);
  if (overlaps()) {
    // An overlap of bounds is none of the tool; to push it out of them could push a leaf in. What
    // is pushed out looks at all.
    candidates_.begin(input.options.margin, true);
    candidates_.query(at(), wanted, result);
  }
  state.clearance = std::max(state.clearance, shared_clearance(input, candidates_.contacts()));
  linearised_ = linearisation_work(result);
}

PoseError ContactProblem::prepare() noexcept {
  const PoseError error_GH = coupling_error(state_->X_WG, input_->X_WH, state_->phi_GH_W);
  const double wanted = displacement_bound(closing(error_GH), tool_reach(at()));
  candidates_.refresh(at(), wanted, *result_);
  touch(wanted);
  return error_GH;
}

// Saves the linearisation that would only confirm the last one.
bool ContactProblem::settled(const PoseError& error_GH, int unknowns) noexcept {
  if (!full_step_ || result_->queries != queries_ || result_->active_count == 0) {
    return false;
  }
  HD_ASSERT(static_cast<std::size_t>(unknowns) == linearisation_.unknowns());
  const std::optional<Wrench> F_H_W = balanced_wrench(view(), error_GH);
  if (!F_H_W) return false;
  --result_->sub_steps;
  solved_ = Solved::kArrived;
  error_GH_ = error_GH;
  state_->F_H_W = *F_H_W;
  result_->F_H_W = *F_H_W;
  result_->status = ContactStatus::kConverged;
  return true;
}

// Commits what of the full step is admissible; true while another linearisation may help.
bool ContactProblem::step_on(const PoseError& error_GH) noexcept {
  const double tolerance = input_->options.stop_tolerance;
  const bool last = step_bound(at(), program_.step()) < tolerance;
  Admission admission;
  admissible_fraction(view(), {program_, error_GH, candidates_.room_left(), last}, admission,
                      *result_);
  if (!admission.centred) program_.drop_centring(state_->touched.size());
  if (admission.admitted) {
    const double travel = step_bound(at(), admission.step);
    candidates_.moved(travel);
    state_->travel += travel;
    state_->X_WG = admission.X_WG;
    strings_.commit(*input_, admission.step, *state_);
    friction_.commit(admission.step, *state_);
    SoftParts::commit(*input_, admission.step, *state_);
    state_->phi_GH_W = admission.phi_GH_W;
    full_step_ = admission.fraction == 1.0;
    queries_ = result_->queries;
  }
  const bool converged = last || step_bound(at(), program_.step()) < tolerance;
  result_->status = converged            ? ContactStatus::kConverged
                    : admission.admitted ? ContactStatus::kLagging
                                         : ContactStatus::kRefused;
  return !converged && admission.admitted;
}

bool ContactProblem::advance() noexcept {
  ++result_->sub_steps;
  const PoseError error_GH = prepare();
  state_->phi_GH_W = error_GH.dtheta;
  const double travel = free_travel(at(), error_GH);
  if (travel <= candidates_.contacts().minimum_gap - state_->clearance) {
    commit_free(travel);
    return false;
  }
  int unknowns = parts_.build(at(), candidates_.contacts(), kToolDof);
  unknowns = strings_.build(at(), candidates_.contacts(), unknowns);
  friction_.build(at(), *state_, candidates_.contacts(), result_->grips_refused);
  if (settled(error_GH, unknowns)) return false;

  result_->pressed += state_->active_count;
  linearisation_.build(view(), error_GH, unknowns);
  program_.solve(view(), linearisation_, *result_);
  if (!program_.optimal()) {
    solved_ = Solved::kNothing;
    keep_after_failure(error_GH);
    return false;
  }
  solved_ = Solved::kAhead;
  error_GH_ = error_GH;
  take_force(error_GH);
  p_program_W_ = state_->X_WG.p;
  return step_on(error_GH);
}

bool ContactProblem::work_used_up() noexcept {
  if (input_->work_budget <= 0) return false;
  const std::int64_t last = linearisation_work(*result_) - linearised_;
  linearised_ += last;
  return tick_work(*result_) + last + last / kDearerNext + candidates_.tests_of_next_look() >
         input_->work_budget;
}

// What the clearance keeps off is not felt: a program that asks for none of it gives the force.
void ContactProblem::render_surface() noexcept {
  if (solved_ == Solved::kNothing || result_->active_count == 0) return;
  if (program_.solve_surface(view(), linearisation_, solved_ == Solved::kArrived, *result_)) {
    take_force(error_GH_);
  }
}

// Where the last linearisation met nothing, no program has the last word.
void ContactProblem::tell_residual() noexcept {
  ContactResult& result = *result_;
  if (result.status == ContactStatus::kFree) return;
  if (result.status == ContactStatus::kQpFailed) {
    const PoseError error_GH = coupling_error(state_->X_WG, input_->X_WH, state_->phi_GH_W);
    result.residual_force =
        unbalanced_force(input_->stiffness, input_->X_WH.q, error_GH, state_->F_H_W);
    result.residual_gap = std::max(0.0, -candidates_.contacts().minimum_gap);
    return;
  }
  const ProgramResidual residual = program_.residual(linearisation_, input_->stiffness);
  result.residual_force = residual.force;
  result.residual_gap = residual.gap;
}

void ContactProblem::finish() noexcept {
  render_surface();
  tell_residual();
  const bool stopped_short =
      result_->status == ContactStatus::kLagging || result_->status == ContactStatus::kRefused;
  if (stopped_short) {
    const std::span pressed(pressed_before_.begin(), pressed_before_.size());
    drop_phantoms(view(), {p_program_W_, pressed}, *state_, *result_);
  }
  YieldingStrings::finish(*input_, state_->touched);
  RigidFriction::finish(*input_, state_->grips);
  state_->clearance = clearance_after(input_->options, state_->clearance, result_->status);
}

void ContactProblem::recover() noexcept {
  ContactResult& result = *result_;
  ContactState& state = *state_;
  const ContactSet& contacts = candidates_.contacts();
  result.status = ContactStatus::kRecovering;
  result.sub_steps = 1;
  const double skin = skin_of(input_->options);
  Vector3 dp_W;
  const bool planned = program_.find_way_out(at(), contacts, dp_W, result);
  std::optional<Push> push;
  if (planned) push = push_out(at(), contacts, dp_W);
  if (!push) push = push_out(at(), contacts, deepest_direction(contacts, false, skin));
  if (!push) push = push_out(at(), contacts, deepest_direction(contacts, true, skin));
  if (push) {
    state.X_WG = push->X_WG;
    result.minimum_gap = push->minimum_gap;
  }
  const PoseError error_GH = coupling_error(state.X_WG, input_->X_WH, state.phi_GH_W);
  state.phi_GH_W = error_GH.dtheta;
  state.active_count = 0;
  result.residual_gap = std::max(0.0, -result.minimum_gap);
  const Wrench pull = coupling_pull(input_->stiffness, input_->X_WH.q, error_GH);
  state.F_H_W = {-pull.f, -pull.t};
  result.F_H_W = state.F_H_W;
}

void ContactProblem::solve(const ContactInput& input, ContactState& state,
                           ContactResult& result) noexcept {
  begin(input, state, result);
  if (overlaps()) {
    recover();
    return;
  }
  bool more = true;
  while (more && result.sub_steps < input.options.sub_steps && !result.cut_short) {
    more = advance();
    result.cut_short = more && work_used_up();
  }
  finish();
}

}  // namespace hapticd
