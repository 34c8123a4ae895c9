// See owned_simulation.h.
#include "core/scene/owned_simulation.h"

namespace hapticd {

OwnedSimulation own_simulation(std::span<const ToolScene> scenes) {
  OwnedSimulation own;
  own.tools.resize(scenes.size());
  std::size_t modes = 0;
  for (std::size_t tool = 0; tool < scenes.size(); ++tool) {
    own.tools[tool].scene = scenes[tool];
    if (scenes[tool].instrument.modes > 0) modes = scenes[tool].strings.size();
  }
  const std::size_t strings = scenes.front().strings.size();
  own.tracks.resize(strings);
  own.visits.resize(scenes.size() * strings);
  own.modes.resize(modes);
  own.simulation =
      std::make_unique<Simulation>(SimulationMemory{own.tools, own.tracks, own.visits, own.modes});
  return own;
}

}  // namespace hapticd
