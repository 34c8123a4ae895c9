// A hand that may send anything, and the guard between it and a simulation of one tool, as the loop
// has it: a bad sample is bridged with the last good pose for two ticks, then force stays off until
// clear(). Frame: W. Not RT.
#pragma once

#include <cstdint>
#include <limits>

#include "core/safety/pose_guard.h"
#include "tests/support/simulation_tick.h"

namespace hapticd::test {

enum class PoseVerdict : std::uint8_t { kGood, kHeld, kFault };

class GuardedHand {
 public:
  /// Judges what the hand sends; hand() is then the pose to go on with.
  PoseVerdict take(const HandPose& sent) {
    DeviceSample sample;
    sample.t_ns = sent.t_ns;
    sample.counter = ++count_;
    sample.p_DH = sent.p_WH;
    sample.q_DH = sent.q_WH;
    GuardLimits limits;
    limits.velocity_trip = std::numeric_limits<double>::infinity();
    limits.report_interval_ns = 0;
    const JudgedPose judged = judge(&sample, 0.0, limits, guard_);
    if (!judged.held) hand_ = sent;
    latched_ = latched_ || !judged.usable;
    verdict_ = judged.held ? PoseVerdict::kHeld : PoseVerdict::kGood;
    if (latched_) verdict_ = PoseVerdict::kFault;
    return verdict_;
  }
  /// Of what was sent last.
  [[nodiscard]] PoseVerdict verdict() const noexcept { return verdict_; }
  /// Force may come back, once the numbers are good again.
  void clear() { latched_ = false; }
  /// The last good pose, as it was sent.
  [[nodiscard]] const HandPose& hand() const noexcept { return hand_; }
  [[nodiscard]] bool has_pose() const noexcept { return guard_.has_pose; }

 private:
  PoseGuard guard_;
  HandPose hand_;
  std::uint64_t count_ = 0;
  bool latched_ = false;
  PoseVerdict verdict_ = PoseVerdict::kFault;
};

/// One tick of one tool among strings that do not vibrate.
inline void render_tool(const ToolScene& scene, const HandPose& hand, ToolState& state,
                        ContactProblem& problem, RenderedTool& tick) noexcept {
  render_contact(scene, hand, state, problem, tick);
  limit_wrench(scene, state, tick);
}

/// What a tick tells in which nothing is rendered: the hand moves on, G stays.
inline void skip_tool(const GuardedHand& hand, ToolState& state, RenderedTool& tick) noexcept {
  if (hand.has_pose()) tick.dt = follow(hand.hand(), state.hand);
  tick.X_WH = state.hand.X_WH;
  tick.X_WG = state.contact.X_WG;
  tick.F_H_W = tick.F_computed_H_W = Wrench{};
  tick.contact = ContactResult{};
  tick.strings.clear();
}

/// What one tool is rendered with.
struct SingleTool {
  const ToolScene& scene;
  ToolState& state;
  ContactProblem& problem;
};

/// render_tool() behind the guard.
inline PoseVerdict guarded_render(const HandPose& sent, GuardedHand& hand, const SingleTool& tool,
                                  RenderedTool& tick) {
  const PoseVerdict verdict = hand.take(sent);
  if (verdict == PoseVerdict::kFault) {
    skip_tool(hand, tool.state, tick);
  } else {
    render_tool(tool.scene, hand.hand(), tool.state, tool.problem, tick);
  }
  return hand.verdict();
}

/// Simulation::step() behind the guard. What was held while nothing is rendered has done no work.
inline PoseVerdict guarded_step(const HandPose& sent, GuardedHand& hand, Simulation& simulation,
                                SimulationTick& output) {
  const PoseVerdict verdict = hand.take(sent);
  if (verdict != PoseVerdict::kFault) {
    output.step(simulation, hand.hand());
    return verdict;
  }
  output.skip(simulation);
  ToolPlay& play = simulation.memory().tools[0];
  skip_tool(hand, play.state, play.rendered);
  for (const std::int32_t string : simulation.strings().awake_strings()) {
    simulation.memory().tracks[static_cast<std::size_t>(string)].state.tank.held_force = 0.0;
  }
  return verdict;
}

}  // namespace hapticd::test
