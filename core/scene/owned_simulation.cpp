// See owned_simulation.h.
#include "core/scene/owned_simulation.h"

#include <algorithm>

namespace hapticd {
namespace {

void make_views(OwnedSimulation& own) {
  const ObstaclesView& obstacles = own.tools.front().scene.obstacles;
  const std::size_t strings = own.tracks.size();
  const std::size_t capsules = obstacles.capsules_W.size() + kMaxRigidParts;
  const std::size_t groups = group_count(capsules);
  own.capsules_W.resize(own.tools.size() * capsules);
  own.groups.resize(own.tools.size() * groups);
  own.strings.resize(own.tools.size() * strings);
  own.scratch = std::make_unique<ContactSet>();
  for (std::size_t tool = 0; tool < own.tools.size(); ++tool) {
    StringSegments& view = own.tools[tool].view;
    view.capsules_W = std::span(own.capsules_W).subspan(tool * capsules, capsules);
    view.groups = std::span(own.groups).subspan(tool * groups, groups);
    view.strings = std::span(own.strings).subspan(tool * strings, strings);
    std::copy(obstacles.capsules_W.begin(), obstacles.capsules_W.end(), view.capsules_W.begin());
    std::copy(obstacles.groups.begin(), obstacles.groups.end(), view.groups.begin());
  }
}

}  // namespace

OwnedSimulation own_simulation(std::span<const ToolScene> scenes) {
  OwnedSimulation own;
  own.tools.resize(scenes.size());
  std::size_t waves = 0;
  for (std::size_t tool = 0; tool < scenes.size(); ++tool) {
    own.tools[tool].scene = scenes[tool];
    if (scenes[tool].instrument.modes > 0) waves = scenes[tool].strings.size();
  }
  const std::size_t strings = scenes.front().strings.size();
  own.tracks.resize(strings);
  own.visits.resize(scenes.size() * strings);
  own.waves.resize(waves);
  if (scenes.size() > 1 || !scenes.front().rests.empty()) make_views(own);
  own.simulation = std::make_unique<Simulation>(
      SimulationMemory{own.tools, own.tracks, own.visits, own.waves, own.scratch.get()});
  return own;
}

}  // namespace hapticd
