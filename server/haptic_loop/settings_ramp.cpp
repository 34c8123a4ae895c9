// See settings_ramp.h. RT: yes.
#include "server/haptic_loop/settings_ramp.h"

#include <algorithm>
#include <utility>

namespace hapticd {
namespace {

using PulledTools = FixedVector<PulledTool, kMaxTools>;

PulledTools pulled_tools(std::span<const ToolLoop> tools, const PlayedScene& scene) noexcept {
  PulledTools pulled;
  for (std::size_t k = 0; k < tools.size(); ++k) {
    const ToolPlay& play = scene.play.tools[k];
    pulled.push_back({tools[k].sample.p_DH, play.X_WH, play.state.contact.X_WG});
  }
  return pulled;
}

}  // namespace

bool SettingsRamp::take(std::unique_ptr<SettingsChange>& change,
                        const PlayedScene& scene) noexcept {
  if (change->to.pieces.size() != scene.settings.pieces.size() ||
      change->to.tools.size() != scene.settings.tools.size() || waiting_count_ == waiting_.size()) {
    return false;
  }
  waiting_[waiting_count_++] = std::move(change);
  return true;
}

std::uint64_t SettingsRamp::follow(const LoopTime& time, std::span<const ToolLoop> tools,
                                   PlayedScene& scene, Publisher& publisher) noexcept {
  std::uint64_t begun = 0;
  std::size_t kept = 0;
  for (std::size_t k = 0; k < waiting_count_; ++k) {
    std::unique_ptr<SettingsChange> change = std::move(waiting_[k]);
    if (change->at_tick > time.tick) {
      waiting_[kept++] = std::move(change);
      continue;
    }
    publisher.retire(std::move(change_));
    change_ = std::move(change);
    begin_change(scene, *change_);
    share_ = 0.0;
    begun = change_->number;
  }
  waiting_count_ = kept;
  if (change_ == nullptr) return begun;
  const PulledTools pulled = pulled_tools(tools, scene);
  share_ = next_share(*change_, share_, time.dt_s, scene, {pulled.begin(), pulled.size()});
  follow_change(*change_, share_, scene);
  if (share_ >= 1.0) publisher.retire(std::move(change_));
  return begun;
}

void SettingsRamp::drop_later(std::uint64_t tick, Publisher& publisher) noexcept {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < waiting_count_; ++k) {
    std::unique_ptr<SettingsChange> change = std::move(waiting_[k]);
    if (change->at_tick > tick) {
      publisher.retire(std::move(change), true);
    } else {
      waiting_[kept++] = std::move(change);
    }
  }
  waiting_count_ = kept;
}

void SettingsRamp::end(Publisher& publisher) noexcept {
  publisher.retire(std::move(change_));
  for (std::size_t k = 0; k < waiting_count_; ++k) publisher.retire(std::move(waiting_[k]));
  waiting_count_ = 0;
}

void SettingsRamp::resume(std::unique_ptr<SettingsChange> change, double share) noexcept {
  change_ = std::move(change);
  share_ = share;
}

}  // namespace hapticd
