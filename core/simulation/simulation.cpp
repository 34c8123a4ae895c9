// Joins contact and strings in one tick. See simulation.h. RT: yes.
#include "core/simulation/simulation.h"

#include <algorithm>
#include <cmath>

#include "core/contact/tick_work.h"
#include "core/math/plain.h"
#include "core/simulation/string_rests.h"
#include "core/simulation/told_bends.h"
#include "core/simulation/told_gap.h"

namespace hapticd {
namespace {

/// A tool is rendered anew where a string comes to lie on other rests in the tick, so often at
/// most. Without, it would be pressed past a rest, and thrown back.
constexpr int kRestTries = 3;

/// What was done for nothing was done all the same.
void add_attempt(const ContactSummary& before, ContactSummary& tool) noexcept {
  tool.sub_steps += before.sub_steps;
  tool.qp_iterations += before.qp_iterations;
  tool.queries += before.queries;
  tool.tests += before.tests;
  tool.evaluations += before.evaluations;
  tool.rows += before.rows;
  tool.pressed += before.pressed;
  tool.string_pairs += before.string_pairs;
  tool.cut_short = tool.cut_short || before.cut_short;
}

/// Only the translation: what turns the hand is small beside it.
void damp_coupling(ToolPlay& play) noexcept {
  RenderedTool& tick = play.rendered;
  if (!(play.scene.coupling_damping > 0.0 && tick.dt > 0.0)) return;
  const Vector3 v_WG = (tick.X_WG.p - play.way.X_WG_before.p) / tick.dt;
  tick.F_computed_H_W.f -= play.scene.coupling_damping * (tick.V_WH.v - v_WG);
}

void add_work(const ContactSummary& tool, WorkTick& work) noexcept {
  work.sub_steps += static_cast<std::uint32_t>(tool.sub_steps);
  work.qp_iterations += static_cast<std::uint32_t>(tool.qp_iterations);
  work.sphere_tests += static_cast<std::uint64_t>(tool.tests);
  work.work += static_cast<std::uint64_t>(tick_work(tool));
  work.cut_short = work.cut_short || tool.cut_short;
}

void tell(const RenderedTool& rendered, ToolTick& told) noexcept {
  told.X_WH = to_plain(rendered.X_WH);
  told.V_WH = to_plain(rendered.V_WH);
  told.X_WG = to_plain(rendered.X_WG);
  told.contact = rendered.contact;
  told.F_computed_H_W = to_plain(rendered.F_computed_H_W);
}

}  // namespace

Simulation::Simulation(const SimulationMemory& memory) noexcept
    : memory_(memory), strings_(memory) {
  HD_ASSERT(!memory.tools.empty() && memory.tools.size() <= kMaxTools);
  HD_ASSERT(memory.tracks.size() <= static_cast<std::size_t>(kMaxStrings));
  HD_ASSERT(memory.visits.size() == memory.tools.size() * memory.tracks.size());
  for (const ToolPlay& play : memory.tools) {
    HD_ASSERT(play.scene.strings.size() == memory.tracks.size());
    HD_ASSERT(play.scene.instrument.modes == 0 || memory.waves.size() == memory.tracks.size());
  }
}

// The contact problem of a tool.
void Simulation::render(std::size_t tool, const HandPose& hand, std::int64_t work_budget) noexcept {
  ToolPlay& play = memory_.tools[tool];
  RenderedTool& tick = play.rendered;
  ToolWay& way = play.way;
  way.X_WG_before = play.state.contact.X_WG;
  const std::int64_t t_before = play.state.hand.t_ns;
  const bool first = !play.state.hand.has_pose;
  if (memory_.tools.size() > 1 || !play.scene.rests.empty()) {
    render_shared(tool, hand, work_budget);
  } else {
    render_contact(play.scene, hand, play.state, play.problem, tick, work_budget);
    way.input = contact_input(play.scene, tick.X_WH, tick.dt);
  }
  way.input.obstacles.blends = &play.problem.blends();
  way.time = {play.state.hand.t_ns, first ? 0 : play.state.hand.t_ns - t_before};
  way.X_WH_before = first ? tick.X_WH : play.X_WH;
  if (first || way.time.dt_ns > 0) play.X_WH = tick.X_WH;
}

// Among the others, which are where their last turn has left them.
void Simulation::render_shared(std::size_t tool, const HandPose& hand,
                               std::int64_t work_budget) noexcept {
  ToolPlay& play = memory_.tools[tool];
  StringTools tools;
  const std::span<const StringTool> all = string_tools(memory_, tools);
  const auto number = static_cast<std::int32_t>(tool);
  FixedVector<OtherTool, kMaxTools - 1> others;
  for (std::size_t k = 0; k < memory_.tools.size(); ++k) {
    const ToolPlay& other = memory_.tools[k];
    if (k == tool || !other.state.placed) continue;
    const ContactState& state = other.state.contact;
    others.push_back(
        {other.scene.tool, state.X_WG, other.scene.parts, &state.parts, state.clearance});
  }
  ContactSummary spent;
  for (int attempt = 1;; ++attempt) {
    ToolScene seen = segment_strings(all, strings_.sharing(), number, to_vector(hand.p_WH));
    seen.others = {{others.begin(), others.size()}, memory_.scratch};
    const bool may_repeat = !seen.rests.empty() && attempt < kRestTries;
    if (!seen.rests.empty()) play.before = play.state;
    const std::int64_t left = std::max<std::int64_t>(work_budget - tick_work(spent), 1);
    render_contact(seen, hand, play.state, play.problem, play.rendered, work_budget > 0 ? left : 0);
    add_attempt(spent, play.rendered.contact);
    update_sharing(all, number, strings_.sharing());
    seen.others = {};
    play.way.input = contact_input(seen, play.rendered.X_WH, play.rendered.dt);
    const bool settled =
        seen.rests.empty() || settle_rests(all, number, play.before, strings_.sharing());
    if (settled || !may_repeat) {
      if (!seen.rests.empty()) add_rest_forces(all[tool], play.way.input, play.rendered);
      return;
    }
    play.state = play.before;
    spent = play.rendered.contact;
  }
}

void Simulation::step(Tick& tick) noexcept {
  HD_ASSERT(tick.tools.size() == memory_.tools.size());
  tick.work = {};
  const auto budget = static_cast<std::int64_t>(tick.budget.work);
  for (std::size_t tool = 0; tool < memory_.tools.size(); ++tool) {
    const auto sharers = static_cast<std::int64_t>(memory_.tools.size() - tool);
    const std::int64_t left = budget - static_cast<std::int64_t>(tick.work.work);
    render(tool, tick.tools[tool].placed,
           budget > 0 ? std::max<std::int64_t>(left / sharers, 1) : 0);
    add_work(memory_.tools[tool].rendered.contact, tick.work);
  }
  StageClock* const clock = memory_.tools.front().scene.clock;
  std::array<double, kMaxTools> gaps;
  for (std::size_t tool = 0; tool < memory_.tools.size(); ++tool) {
    gaps[tool] = told_gap(memory_, strings_.sharing(), tool);
  }
  lap(clock, Stage::kOptimisation);
  strings_.play(tick);
  tell_bends(memory_, strings_.sharing(), tick);
  lap(clock, Stage::kStrings);
  for (std::size_t tool = 0; tool < memory_.tools.size(); ++tool) {
    ToolPlay& play = memory_.tools[tool];
    damp_coupling(play);
    limit_wrench(play.scene, play.state, play.rendered);
    tell(play.rendered, tick.tools[tool]);
    tick.tools[tool].contact.minimum_gap = gaps[tool];
  }
}

void Simulation::stand(std::span<const Pose> X_WG_home, Tick& tick) noexcept {
  for (std::size_t tool = 0; tool < memory_.tools.size(); ++tool) {
    const ToolState& state = memory_.tools[tool].state;
    const Pose& X_WG = state.placed ? state.contact.X_WG : X_WG_home[tool];
    ToolTick& told = tick.tools[tool];
    told.X_WG = to_plain(X_WG);
    told.X_WH = state.hand.has_pose ? to_plain(state.hand.X_WH) : told.X_WG;
    told.contact.minimum_gap = standing_gap(memory_, strings_.sharing(), tool, X_WG);
  }
  tell_bends(memory_, strings_.sharing(), tick);
}

void Simulation::restart() noexcept {
  // Of its view a tool knows itself which strings are in parts.
  for (ToolPlay& play : memory_.tools) {
    play.state = ToolState{};
    play.view.rigid_active.clear();
  }
  for (PlayedString& track : memory_.tracks) track = PlayedString{};
  for (ToolStringState& visit : memory_.visits) visit = ToolStringState{};
  for (WaveMemory& wave : memory_.waves) wave.state = WaveState{};
  static_cast<void>(strings_.set_awake({}));
  strings_.sharing().clear();
}

}  // namespace hapticd
