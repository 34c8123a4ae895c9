// See quality_governor.h.
#include "server/daemon/quality_governor.h"

#include <algorithm>

namespace hapticd {
namespace {

void begin_window(std::int64_t t_ns, QualityGovernor& governor) noexcept {
  governor.window_ns = t_ns;
  governor.ticks = governor.over_budget = governor.over_room = 0;
}

int change(int level, std::int64_t t_ns, QualityGovernor& governor) noexcept {
  governor.level = level;
  governor.settled_ns = t_ns + kSettling_ns;
  governor.calm = 0;
  begin_window(governor.settled_ns, governor);
  return level;
}

/// The level that was too much waits, and longer each time.
int descend(std::int64_t t_ns, QualityGovernor& governor) noexcept {
  QualityGovernor::Rung& rung = governor.rungs[static_cast<std::size_t>(governor.level)];
  rung.retry_ns = t_ns + rung.wait_ns;
  rung.wait_ns = std::min(2 * rung.wait_ns, kMaxRetry_ns);
  governor.reason = QualityReason::kBudget;
  return change(governor.level - 1, t_ns, governor);
}

int judge_window(std::int64_t t_ns, QualityGovernor& governor) noexcept {
  if (governor.ticks == 0) {
    begin_window(t_ns, governor);
    return governor.level;
  }
  const bool calm = governor.over_room * kOverOneIn <= governor.ticks;
  governor.calm = calm ? governor.calm + 1 : 0;
  begin_window(t_ns, governor);
  const int above = governor.level + 1;
  governor.reason = calm ? QualityReason::kRoom : QualityReason::kBudget;
  if (!calm || above == kQualityLevels) return governor.level;
  if (t_ns < governor.rungs[static_cast<std::size_t>(above)].retry_ns) {
    governor.reason = QualityReason::kSettling;
    return governor.level;
  }
  return governor.calm < kCalmWindows ? governor.level : change(above, t_ns, governor);
}

}  // namespace

int govern(const TickCost& tick, std::int64_t budget_ns, QualityGovernor& governor) noexcept {
  if (governor.level < 0) change(tick.level, tick.t_ns, governor);
  // Ticks of the level before are on their way until the change is in force.
  if (tick.level != governor.level) return governor.level;
  if (tick.t_ns < governor.settled_ns) return governor.level;
  if (tick.cpu_ns > 0) {
    ++governor.ticks;
    if (tick.cpu_ns > budget_ns) ++governor.over_budget;
    const auto room_ns = static_cast<std::int64_t>(kRoomShare * static_cast<double>(budget_ns));
    if (tick.cpu_ns > room_ns || tick.cut_short) ++governor.over_room;
  }
  // Not only at the window's end: a burst is answered at its third tick.
  const std::uint64_t allowed = std::max<std::uint64_t>(governor.ticks / kOverOneIn, 2);
  if (governor.over_budget > allowed && governor.level > 0) return descend(tick.t_ns, governor);
  if (tick.t_ns - governor.window_ns < kGovernorWindow_ns) return governor.level;
  return judge_window(tick.t_ns, governor);
}

}  // namespace hapticd
