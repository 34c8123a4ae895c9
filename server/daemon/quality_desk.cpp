// See quality_desk.h.
#include "server/daemon/quality_desk.h"

#include <spdlog/spdlog.h>

#include <cmath>

#include "core/contact/tick_work.h"

namespace hapticd {

void QualityDesk::follow(const Tick& tick) {
  const LiveScene& scene = scenes_.newest();
  // The one that is on its way begins with a bound of its own.
  if (tick.scene_id != scene.id) return;
  if (tick.scene_id != scene_id_) {
    scene_id_ = tick.scene_id;
    governor_ = QualityGovernor{};
    forget_prices();
    allowed_ = static_cast<std::int64_t>(tick.budget.work);
  }
  if (!tick.budget.automatic) governor_ = QualityGovernor{};
  // The bound is for the next tick.
  const double budget_us = tick_budget_us(scene.quality_at(tick.tick + 1), player_);
  if (budget_us == 0.0) {
    forget_prices();
    allow(0);
    return;
  }
  std::int64_t cost_ns = 0;
  if (stepped_here_) {
    cost_ns = std::llround(kNominalWork_ns * static_cast<double>(tick.work.work));
    allow(nominal_work(1e3 * budget_us));
  } else {
    const PricedTick before = tick_before(tick);
    cost_ns = judged_cost(before, price_);
    learn(before, price_);
    allow(affordable_work(1e3 * budget_us, price_));
  }
  // A change that waits for its tick would be overtaken by one made from its values.
  const LiveSettings& now = scene.settings.tools.front();
  const bool automatic = tick.budget.automatic && now.quality_automatic;
  const bool waits = tick.tick < scenes_.change_tick();
  if (automatic && !waits) follow_level(tick, cost_ns, budget_us);
}

void QualityDesk::forget_prices() {
  price_ = WorkCost{};
  before_.reset();
}

// A tick tells the time of the one before. Where one found no place in the ring, or the scene
// is new, that tick is not known.
PricedTick QualityDesk::tick_before(const Tick& tick) {
  PricedTick before;
  const std::uint64_t overruns = tick.times.overruns;
  if (before_ && before_->next_tick + (overruns - before_->overruns) == tick.tick) {
    before = {tick.times.cpu_ns, static_cast<std::int64_t>(before_->work)};
  }
  before_ = TickBefore{tick.tick + 1, overruns, tick.work.work};
  return before;
}

void QualityDesk::allow(std::int64_t work) {
  if (replays_ || !worth_telling(work, allowed_)) return;
  if (loop_.post(WorkBudgetCommand{work})) allowed_ = work;
}

void QualityDesk::follow_level(const Tick& tick, std::int64_t cost_ns, double budget_us) {
  const TickCost cost{tick.t_ns, cost_ns, static_cast<int>(tick.budget.level), tick.work.cut_short};
  const int level = govern(cost, std::llround(1e3 * budget_us), governor_);
  const LiveSettings& now = scenes_.newest().settings.tools.front();
  if (level == static_cast<int>(now.quality_level)) return;
  if (!scenes_.set_level(level, tick.tick)) return;
  spdlog::info("quality {} for a budget of {} us", level, budget_us);
}

void QualityDesk::explain(const Tick& tick, v1::State& state) const {
  if (!state.has_quality()) return;
  v1::QualityState& quality = *state.mutable_quality();
  if (!replays_) {
    const v1::Quality& now = scenes_.playing(tick.scene_id).quality_at(tick.tick);
    quality.set_budget_us(static_cast<float>(tick_budget_us(now, player_)));
  }
  if (!tick.budget.automatic) return;
  quality.set_reason(static_cast<v1::QualityReason>(governor_.reason));
}

}  // namespace hapticd
