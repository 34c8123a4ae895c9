// The work that a tick may do, bounded before it begins by what ticks have cost, and quality that
// follows the same budget. The work goes to the loop as a command, a new level as a change of
// settings does. Under the virtual clock time is no measure: a tick costs its work at the nominal
// price, so that it comes to the same everywhere. Not RT.
#pragma once

#include <cstdint>
#include <optional>

#include "hapticd/v1/state.pb.h"
#include "server/daemon/loop_desk.h"
#include "server/daemon/quality_governor.h"
#include "server/daemon/scene_desk.h"
#include "server/daemon/work_cost.h"

namespace hapticd {

class QualityDesk {
 public:
  /// All outlive this. `stepped_here`: CPU time is no measure.
  QualityDesk(const PlayerOptions& player, SceneDesk& scenes, LoopDesk& loop, bool stepped_here)
      : player_(player), scenes_(scenes), loop_(loop), stepped_here_(stepped_here) {}

  /// A replay obeys the work that was recorded, and its budget is not told.
  void leave_work_alone() noexcept { replays_ = true; }

  /// A tick is over: bounds the work of those that follow, and lets automatic quality change its
  /// level.
  void follow(const Tick& tick);
  /// Adds the budget and why the level is what it is to a State of `tick`.
  void explain(const Tick& tick, v1::State& state) const;

 private:
  /// The tick before the newest one: its time is told with the next.
  struct TickBefore {
    std::uint64_t next_tick = 0;
    std::uint64_t overruns = 0;
    std::uint64_t work = 0;
  };

  [[nodiscard]] PricedTick tick_before(const Tick& tick);
  void forget_prices();
  void allow(std::int64_t work);
  void follow_level(const Tick& tick, std::int64_t cost_ns, double budget_us);

  const PlayerOptions& player_;
  SceneDesk& scenes_;
  LoopDesk& loop_;
  bool stepped_here_;
  bool replays_ = false;
  QualityGovernor governor_;  ///< of automatic quality
  WorkCost price_;            ///< of this machine, under the real clock
  std::optional<TickBefore> before_;
  std::uint32_t scene_id_ = 0;
  std::int64_t allowed_ = 0;  ///< that the loop was told last, or began with; 0: no bound
};

}  // namespace hapticd
