// The tick: a pose of each tool's hand in; graphic tools, wrenches, strings and events out. The
// contact problem of each tool in turn (rendering), then the response of every string that is
// touched or rings (instrument), whose vibration adds to the wrench of the tool that plays it, then
// the limits. What `step` computes is a pure function of state and input, the same bits everywhere:
// no device, no random source, and a clock only where it is lent one to time stages by. RT: yes.
#pragma once

#include <span>

#include "core/simulation/string_players.h"
#include "core/simulation/tool_play.h"

namespace hapticd {

/// One to five tools among the strings and bodies of a scene. Each has its own wrench; what they
/// share is the strings.
class Simulation {
 public:
  explicit Simulation(const SimulationMemory& memory) noexcept;

  /// One tick. Reads the work that `tick` is allowed and where each hand is placed; `tick.tools`
  /// has an entry for every tool. Writes what core/tick/tick.h says is the simulation's. What a
  /// tool leaves of its share of the work is for those after it. Cost per tool: about 0.3 us free,
  /// 2 us on a string (tests/benchmark).
  HD_REALTIME void step(Tick& tick) noexcept;

  /// A tick in which no tool can be rendered: tells where they and the strings stand; a tool that
  /// has not been placed stands at `X_WG_home`, one per tool.
  HD_REALTIME void stand(std::span<const Pose> X_WG_home, Tick& tick) noexcept;

  /// Begins anew, as after construction: tools go to their hands, strings are at rest and silent.
  /// Bounded by the strings there are, about 0.2 us each.
  HD_REALTIME void restart() noexcept;

  /// What the last step gave of a tool, for who goes on with it in the same tick.
  [[nodiscard]] const RenderedTool& rendered(std::size_t tool) const noexcept {
    return memory_.tools[tool].rendered;
  }
  /// What happened to strings in the last step.
  [[nodiscard]] const StringEvents& events() const noexcept { return strings_.events(); }

  [[nodiscard]] std::size_t tool_count() const noexcept { return memory_.tools.size(); }
  /// The scene of a tool, to change what may change between ticks. Strings and instrument are to be
  /// changed alike for all tools.
  [[nodiscard]] ToolScene& scene(std::size_t tool) noexcept { return memory_.tools[tool].scene; }

  /// All that goes from tick to tick, with what strings() says: for snapshots and replay
  /// (simulation_fields.h). Of a tool: its state, X_WH and view.
  [[nodiscard]] const SimulationMemory& memory() const noexcept { return memory_; }
  [[nodiscard]] const StringPlayers& strings() const noexcept { return strings_; }
  [[nodiscard]] StringPlayers& strings() noexcept { return strings_; }

 private:
  void render(std::size_t tool, const HandPose& hand, std::int64_t work_budget) noexcept;
  void render_shared(std::size_t tool, const HandPose& hand, std::int64_t work_budget) noexcept;

  SimulationMemory memory_;
  StringPlayers strings_;
};

}  // namespace hapticd
