// What a tick of a scene costs on this machine: a tool is led from its start to the objects of the
// scene, into them and over them, and every tick is timed. Offline.
#pragma once

#include <cstddef>

#include "core/scene/scene.h"

namespace hapticd {

/// Processor times of ticks, us.
struct TickTimes {
  int ticks = 0;
  double median = 0.0;
  double p99 = 0.0;
  double worst = 0.0;
};

struct TickCost {
  TickTimes free;     ///< nothing near
  TickTimes contact;  ///< something presses
};

/// Leads tool number `tool` to at most `objects` objects, evenly chosen, each time from its start
/// at 1 m/s until the middle of its nearest sphere is on the object's surface or axis, then along
/// it.
[[nodiscard]] TickCost measure_ticks(const Scene& scene, std::size_t tool, int objects);

}  // namespace hapticd
