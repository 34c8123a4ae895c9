// Where the strings of a simulation are, for judges that need the line itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/simulation/simulation.h"

namespace hapticd::test {

/// A string after step(): its ends and the vertices that tools bend it to, from A to B, in W, m.
[[nodiscard]] inline StringPoints string_shape(const Simulation& simulation, std::int32_t string) {
  const SimulationMemory& memory = simulation.memory();
  StringTools tools;
  StringPoints points;
  string_points(string_tools(memory, tools), simulation.strings().sharing(), string, -1, points);
  if (memory.tools.size() > 1 || !memory.tools.front().scene.rests.empty()) return points;
  // One tool holds what it holds.
  const ToolPlay& play = memory.tools.front();
  const Capsule& line = play.scene.obstacles.capsules_W[static_cast<std::size_t>(string)];
  for (const TouchedString& hold : play.state.contact.touched) {
    if (hold.bend.capsule != string || !hold.yields) continue;
    points.truncate(1);
    points.push_back(leg_of(line, hold.bend, 0).capsule_W.p_B);
    points.push_back(line.p_B);
  }
  return points;
}

}  // namespace hapticd::test
