// Which tool plays a string, and what the others that touch it do. A string vibrates once, however
// many tools touch it: its energy, tank and detector go with the tool that plays it, and the force
// of its vibration goes to that tool alone. A tool that comes to a string which another one touches
// is watched beside it; when it lets go while it has bent the string, it plays: so a finger may
// stop a string and another pluck it, in whatever order they come. Strings that are untouched and
// silent are never looked at. RT: yes, one tool pays for none of what several need.
#pragma once

#include <cstdint>
#include <span>

#include "core/simulation/string_proximity.h"
#include "core/simulation/tool_play.h"
#include "core/tick/string_event.h"

namespace hapticd {

/// All strings of a simulation, and which of them respond to the next tick.
class StringPlayers {
 public:
  /// `memory` as of a Simulation.
  explicit StringPlayers(const SimulationMemory& memory) noexcept : memory_(memory) {}

  /// The response of every string that is touched or rings, once the contact problems of all tools
  /// are solved: its events, and what its vibration adds to the wrench of its tool. Writes columns
  /// and energies of strings.
  HD_REALTIME void play(Tick& tick) noexcept;

  /// Of the last play(). Never part of a snapshot.
  [[nodiscard]] const StringEvents& events() const noexcept { return events_; }

  /// What the vibrating strings that `tool` plays may still give to its hand, J.
  [[nodiscard]] HD_REALTIME double tank_energy(std::size_t tool) const noexcept;
  /// The same of all strings, J.
  [[nodiscard]] HD_REALTIME double tank_energy() const noexcept;

  /// Strings that respond to the next tick, in ascending order.
  [[nodiscard]] std::span<const std::int32_t> awake_strings() const noexcept {
    return {awake_.begin(), awake_.size()};
  }
  /// Makes just these awake; false, and nothing is changed, when they are no strings in ascending
  /// order.
  [[nodiscard]] bool set_awake(std::span<const std::int32_t> strings) noexcept;

  /// Who holds which string, empty with one tool; what goes from tick to tick of it all is this
  /// and the awake strings, beside the memory. To be changed in a simulation just made, or by a
  /// tool's turn.
  [[nodiscard]] const StringSharing& sharing() const noexcept { return sharing_; }
  [[nodiscard]] StringSharing& sharing() noexcept { return sharing_; }

 private:
  struct Sounding;
  [[nodiscard]] Sounding sounding_part(std::int32_t string) const noexcept;
  void find_ringing(ToolPlay& play) noexcept;
  void merge_touched(const PressedStrings& touched) noexcept;
  void respond_string(std::int32_t string, Tick& tick) noexcept;
  void play_string(std::int32_t string, const StringProximity& near, Tick& tick) noexcept;
  void watch_others(std::int32_t string, std::span<const StringProximity> near) noexcept;
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
  StringSharing sharing_;
  StringEvents events_;
};

}  // namespace hapticd
