// The tick: a pose of each tool's hand in; graphic tools, wrenches, strings and events out. The
// contact problem of each tool in turn (rendering), then the response of every string that is
// touched or rings (instrument), whose vibration adds to the wrench of the tool that plays it, then
// the limits. `step` is a pure function of state and input: no clock, device or random source; the
// same scene and inputs give the same bits everywhere. Strings that are untouched and silent are
// never looked at outside the broad phase. RT: yes.
#pragma once

#include <array>
#include <span>

#include "core/simulation/contact_report.h"
#include "core/simulation/string_proximity.h"
#include "core/simulation/string_segments.h"
#include "core/simulation/tool_play.h"
#include "core/tick/string_tick.h"

namespace hapticd {

/// What one tick is computed from: a pose per tool, in the order of the tools; further ones are not
/// looked at.
struct TickInput {
  std::array<HandPose, kMaxTools> hands;
  /// Work of all tools together (core/contact/tick_work.h), chosen before the tick, >= 0; what a
  /// tool leaves of its share is for those after it. 0: no bound.
  std::int64_t work_budget = 0;
};

/// The input of a simulation of one tool.
[[nodiscard]] inline TickInput input_of(const HandPose& hand) noexcept {
  TickInput input;
  input.hands[0] = hand;
  return input;
}

/// What one tick gives.
struct TickOutput {
  FixedVector<RenderedTool, kMaxTools> tools;
  StringEvents events;
  FixedVector<StringTick, kMaxStrings> strings;
};

/// What the simulation keeps of each string between ticks.
struct PlayedString {
  StringState state;        ///< its detector is that of the tool that plays it
  std::int32_t player = 0;  ///< the tool whose touch makes it sound or dampens it
  double place = 0.5;       ///< of that tool's last touch, along the string
};

/// Where a simulation keeps what it knows. Views must outlive it.
struct SimulationMemory {
  std::span<ToolPlay> tools;          ///< 1 to kMaxTools, their scenes set
  std::span<PlayedString> tracks;     ///< one per string, at most kMaxStrings
  std::span<ToolStringState> visits;  ///< one per string, of the first tool, then of the second...
  std::span<ModalString> modes{};     ///< one per string, or none when no modes are modelled
  ContactSet* scratch = nullptr;      ///< null only with one tool
};

/// One to five tools among the strings and bodies of a scene. Each has its own wrench; what they
/// share is the strings.
class Simulation {
 public:
  explicit Simulation(const SimulationMemory& memory) noexcept;

  /// One tick. Cost per tool: about 0.3 us free, 2 us on a string (tests/benchmark).
  HD_REALTIME void step(const TickInput& input, TickOutput& output) noexcept;

  /// The contacts of a tool as they are after step(), deepest first. Cost: about 40 ns per listed
  /// pair.
  HD_REALTIME void report_contacts(std::size_t tool, ContactReport& report) const noexcept;

  /// What the vibrating strings that `tool` plays may still give to its hand, J.
  [[nodiscard]] HD_REALTIME double tank_energy(std::size_t tool) const noexcept;
  /// The same of all strings, J.
  [[nodiscard]] HD_REALTIME double tank_energy() const noexcept;

  [[nodiscard]] std::size_t tool_count() const noexcept { return memory_.tools.size(); }
  /// The scene of a tool, to change what may change between ticks. Strings and instrument are to be
  /// changed alike for all tools.
  [[nodiscard]] ToolScene& scene(std::size_t tool) noexcept { return memory_.tools[tool].scene; }
  [[nodiscard]] const ToolState& tool(std::size_t tool) const noexcept {
    return memory_.tools[tool].state;
  }
  [[nodiscard]] std::span<const PlayedString> tracks() const noexcept { return memory_.tracks; }

  /// All that goes from tick to tick, with awake_strings() and holders(): for snapshots and replay
  /// (simulation_fields.h). Of a tool: its state, X_WH and view.
  [[nodiscard]] const SimulationMemory& memory() const noexcept { return memory_; }
  /// Strings that respond to the next tick, in ascending order.
  [[nodiscard]] std::span<const std::int32_t> awake_strings() const noexcept {
    return {awake_.begin(), awake_.size()};
  }
  /// Makes just these awake; false, and nothing is changed, when they are no strings in ascending
  /// order.
  [[nodiscard]] bool set_awake(std::span<const std::int32_t> strings) noexcept;
  /// Who holds which string; belongs to the state too. To be set in a simulation just made.
  [[nodiscard]] const StringSharing& holders() const noexcept { return holders_; }
  void set_holders(const StringSharing& holders) noexcept { holders_ = holders; }

 private:
  struct Sounding;
  using StringTools = std::array<StringTool, kMaxTools>;
  void render(std::size_t tool, const HandPose& hand, std::int64_t work_budget,
              RenderedTool& tick) noexcept;
  void render_shared(std::size_t tool, const HandPose& hand, std::int64_t work_budget,
                     RenderedTool& tick) noexcept;
  [[nodiscard]] std::span<const StringTool> string_tools(StringTools& tools) const noexcept;
  [[nodiscard]] Sounding sounding_part(std::int32_t string) const noexcept;
  void find_ringing(std::size_t tool) noexcept;
  void merge_touched(const PressedStrings& touched) noexcept;
  void respond_strings(TickOutput& output) noexcept;
  void respond_string(std::int32_t string, TickOutput& output) noexcept;
  void play_string(std::int32_t string, const StringProximity& near, TickOutput& output) noexcept;
  void watch_others(std::int32_t string, std::span<const StringProximity> near,
                    TickOutput& output) noexcept;
  [[nodiscard]] std::int32_t choose_player(std::int32_t string,
                                           std::span<const StringProximity> near) const noexcept;
  void hand_over(std::int32_t string, std::int32_t player, const StringProximity& near) noexcept;
  [[nodiscard]] bool is_awake(std::int32_t string) const noexcept;
  void end_string(std::int32_t string) noexcept;
  [[nodiscard]] ToolStringState& visit(std::size_t tool, std::int32_t string) const noexcept {
    return memory_.visits[tool * memory_.tracks.size() + static_cast<std::size_t>(string)];
  }

  SimulationMemory memory_;
  /// Strings to call respond() for, in ascending order.
  FixedVector<std::int32_t, kMaxStrings> awake_;
  StringSharing holders_;  ///< empty with one tool
};

}  // namespace hapticd
