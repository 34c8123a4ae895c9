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

/// Work of ticks against a budget, at the mean price of work in contact here: what else takes time
/// now and then is not work.
struct BoundedTicks {
  double budget_us = 0.0;
  double most_us = 0.0;  ///< of the tick with the most work
  int ticks = 0;
  int beyond = 0;  ///< ticks whose work takes longer than the budget
};

struct TickCost {
  TickTimes free;     ///< nothing near
  TickTimes contact;  ///< something presses
  BoundedTicks bounded;
};

/// Leads tool number `tool` to at most `objects` objects, evenly chosen, each time from its start
/// at 1 m/s until the middle of its nearest sphere is on the object's surface or axis, then along
/// it. No tick is bounded, but each is held against `budget_us` > 0.
[[nodiscard]] TickCost measure_ticks(const Scene& scene, std::size_t tool, int objects,
                                     double budget_us);

}  // namespace hapticd
