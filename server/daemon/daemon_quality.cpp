// The work that a tick may do, bounded before it begins by what ticks have cost, and quality that
// follows the same budget. The work goes to the loop as a command, a new level as a change of
// settings does. Under the virtual clock time is no measure: a tick costs its work at the nominal
// price, so that it comes to the same everywhere. See daemon.h.
#include <spdlog/spdlog.h>

#include <cmath>

#include "core/contact/tick_work.h"
#include "server/daemon/daemon.h"

namespace hapticd {

QualityWish Daemon::quality_wish() const {
  const v1::Config& config = options_.config;
  QualityWish wish;
  wish.usual_budget_us = usual_budget_us(player_);
  if (config.budget_us() > 0.0) wish.budget_us = config.budget_us();
  if (config.quality().empty()) return wish;
  wish.quality.emplace();
  if (config.quality() == "auto") {
    wish.quality->mutable_automatic();
  } else {
    wish.quality->set_level(static_cast<std::uint32_t>(std::stoul(config.quality())));
  }
  return wish;
}

// The last one that has begun.
const v1::Quality& Daemon::quality_at(const LiveScene& scene, std::uint64_t tick) {
  const LiveScene::Change* last = nullptr;
  for (const LiveScene::Change& each : scene.changes) {
    if (each.at_tick <= tick && (last == nullptr || each.at_tick >= last->at_tick)) last = &each;
  }
  return (last == nullptr ? scene.in_force : last->parameters).live.quality();
}

void Daemon::follow_budget(const Snapshot& snapshot) {
  const LiveScene& scene = scenes_.back();
  // The one that is on its way begins with a bound of its own.
  if (snapshot.scene_id != scene.id) return;
  if (snapshot.scene_id != governed_scene_) {
    governed_scene_ = snapshot.scene_id;
    governor_ = QualityGovernor{};
    forget_prices();
    allowed_work_ = static_cast<std::int64_t>(snapshot.work.work_budget);
  }
  if (!snapshot.quality_automatic) governor_ = QualityGovernor{};
  // The bound is for the next tick.
  const double budget_us = tick_budget_us(quality_at(scene, snapshot.tick + 1), player_);
  if (budget_us == 0.0) {
    forget_prices();
    allow_work(0);
    return;
  }
  std::int64_t cost_ns = 0;
  if (virtual_time_) {
    cost_ns = std::llround(kNominalWork_ns * static_cast<double>(snapshot.work.work));
    allow_work(nominal_work(1e3 * budget_us));
  } else {
    const PricedTick before = tick_before(snapshot);
    cost_ns = judged_cost(before, price_);
    learn(before, price_);
    allow_work(affordable_work(1e3 * budget_us, price_));
  }
  // A change that waits for its tick would be overtaken by one made from its values.
  const LiveSettings& now = scene.settings.tools.front();
  const bool automatic = snapshot.quality_automatic && now.quality_automatic;
  if (automatic && snapshot.tick >= change_tick_) follow_level(snapshot, cost_ns, budget_us);
}

void Daemon::forget_prices() {
  price_ = WorkCost{};
  before_.reset();
}

// A snapshot tells the time of the tick before. Where one found no place in the ring, or the scene
// is new, that tick is not known.
PricedTick Daemon::tick_before(const Snapshot& snapshot) {
  PricedTick before;
  const std::uint64_t overruns = snapshot.timing.overruns;
  if (before_ && before_->next_tick + (overruns - before_->overruns) == snapshot.tick) {
    before = {snapshot.timing.cpu_ns, static_cast<std::int64_t>(before_->work)};
  }
  before_ = TickBefore{snapshot.tick + 1, overruns, snapshot.work.work};
  return before;
}

// A replay obeys the work that was recorded.
void Daemon::allow_work(std::int64_t work) {
  if (replay_ || !worth_telling(work, allowed_work_)) return;
  if (channels_->commands.push({++last_command_, WorkBudgetCommand{work}})) allowed_work_ = work;
}

void Daemon::follow_level(const Snapshot& snapshot, std::int64_t cost_ns, double budget_us) {
  LiveScene& scene = scenes_.back();
  const TickCost cost{snapshot.t_ns, cost_ns, static_cast<int>(snapshot.quality_level),
                      snapshot.work.cut_short};
  const int level = govern(cost, std::llround(1e3 * budget_us), governor_);
  if (level == static_cast<int>(scene.settings.tools.front().quality_level)) return;
  SceneSettings settings = scene.settings;
  for (LiveSettings& live : settings.tools) take_to_level(level, scene.live.solver(), live);
  auto change = std::make_unique<SettingsChange>();
  change->from = settings;
  change->to = settings;
  announce_change(change->to, nullptr);
  if (!channels_->commands.push({++last_command_, ChangeSettingsCommand{change.get()}})) return;
  scene.settings = settings;
  // The loop's from here on.
  scene.changes.push_back(
      {change.release(), snapshot.tick + 1, {scene.live, scene.choice, std::move(settings)}});
  spdlog::info("quality {} for a budget of {} us", level, budget_us);
}

void Daemon::explain_quality(const Snapshot& snapshot, v1::State& state) const {
  if (!state.has_quality()) return;
  v1::QualityState& quality = *state.mutable_quality();
  if (!replay_) {
    const v1::Quality& now = quality_at(playing(snapshot.scene_id), snapshot.tick);
    quality.set_budget_us(static_cast<float>(tick_budget_us(now, player_)));
  }
  if (!snapshot.quality_automatic) return;
  quality.set_reason(static_cast<v1::QualityReason>(governor_.reason));
}

void Daemon::report_budget() const {
  if (player_.budget_us != 0.0) return;
  spdlog::warn(
      "--budget-us 0: the work of a tick has no bound, so fast or deep contact may make it late; "
      "leave the option out to bound it to half the tick");
}

}  // namespace hapticd
