// See live_scene.h.
#include "server/daemon/live_scene.h"

#include <algorithm>
#include <utility>

#include "server/scene_io/told_scene.h"

namespace hapticd {

void LiveScene::take(Parameters now) {
  live = std::move(now.live);
  choice = std::move(now.choice);
  settings = std::move(now.settings);
  tell_scene(live, choice, info);
}

// The last one that has begun.
const v1::Quality& LiveScene::quality_at(std::uint64_t tick) const {
  const Change* last = nullptr;
  for (const Change& each : changes) {
    if (each.at_tick <= tick && (last == nullptr || each.at_tick >= last->at_tick)) last = &each;
  }
  return (last == nullptr ? in_force : last->parameters).live.quality();
}

bool LiveScene::settle(std::uint64_t number, bool dropped) {
  const auto found = std::find_if(changes.begin(), changes.end(),
                                  [&](const Change& each) { return each.number == number; });
  if (found == changes.end()) return false;
  // Changes are over in the order in which they began.
  if (!dropped) in_force = std::move(found->parameters);
  changes.erase(found);
  if (dropped) take(changes.empty() ? in_force : changes.back().parameters);
  return true;
}

}  // namespace hapticd
