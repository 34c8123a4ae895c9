// Quality that follows a budget: what ticks cost is looked at here, and a new level goes to the
// loop as a change of settings does. Under the virtual clock time is no measure, and the level
// stays where automatic quality begins. See daemon.h.
#include <spdlog/spdlog.h>

#include <cmath>

#include "server/daemon/daemon.h"

namespace hapticd {

QualityWish Daemon::quality_wish() const {
  const v1::Config& config = options_.config;
  QualityWish wish;
  wish.usual_budget_us = 0.5e-3 * static_cast<double>(player_.period_ns);
  if (config.has_budget_us()) wish.budget_us = config.budget_us();
  if (config.quality().empty()) return wish;
  wish.quality.emplace();
  if (config.quality() == "auto") {
    wish.quality->mutable_automatic();
  } else {
    wish.quality->set_level(static_cast<std::uint32_t>(std::stoul(config.quality())));
  }
  return wish;
}

void Daemon::follow_budget(const Snapshot& snapshot) {
  AirScene& scene = scenes_.back();
  const bool playing = snapshot.scene_id == scene.id && snapshot.quality_automatic;
  if (virtual_time_ || !playing) {
    governor_ = QualityGovernor{};
    return;
  }
  // A change that waits for its tick would be overtaken by one made from its values.
  const LiveSettings& now = scene.settings.tools.front();
  if (!now.quality_automatic || snapshot.tick < change_tick_) return;
  const double budget_us = scene.live.quality().automatic().budget_us();
  const auto played = static_cast<int>(snapshot.quality_level);
  const int level = govern({snapshot.t_ns, snapshot.timing.cpu_ns, played},
                           std::llround(1e3 * budget_us), governor_);
  if (level == static_cast<int>(now.quality_level)) return;
  SceneSettings settings = scene.settings;
  for (LiveSettings& live : settings.tools) set_level(level, live);
  auto change = std::make_unique<SettingsChange>();
  change->from = settings;
  change->to = settings;
  announce_change(change->to, nullptr);
  if (!channels_->commands.push({++last_command_, ChangeSettingsCommand{change.get()}})) return;
  static_cast<void>(change.release());  // the loop's from here on
  scene.settings = std::move(settings);
  spdlog::info("quality {} for a budget of {} us", level, budget_us);
}

void Daemon::explain_quality(const Snapshot& snapshot, v1::State& state) const {
  if (!state.has_quality() || virtual_time_ || !snapshot.quality_automatic) return;
  state.mutable_quality()->set_reason(static_cast<v1::QualityReason>(governor_.reason));
}

}  // namespace hapticd
