// A simulation with the memory it plays in: what changes while tools play. Offline: made before the
// loop sees it, freed after.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/simulation/simulation.h"

namespace hapticd {

/// A simulation and its memory, which stays where it is when this is moved.
struct OwnedSimulation {
  std::vector<ToolPlay> tools;
  std::vector<PlayedString> tracks;
  std::vector<ToolStringState> visits;
  std::vector<WaveMemory> waves;  ///< none when no string sounds
  // What tools see of strings that others, or rests, hold; none for one tool without rests.
  std::vector<Capsule> capsules_W;
  std::vector<CapsuleGroup> groups;
  std::vector<StringConstants> strings;
  std::unique_ptr<ContactSet> scratch;
  std::unique_ptr<Simulation> simulation;
};

/// A simulation of `scenes`, one per tool, 1 to kMaxTools, alike in strings, obstacles and
/// instrument; their views must outlive it.
[[nodiscard]] OwnedSimulation own_simulation(std::span<const ToolScene> scenes);

}  // namespace hapticd
