// Scenes, gestures and settings of the loop: taken, begun, given back; what a lost lease takes with
// it, and what Clear mends. See haptic_loop.h. RT: yes.
#include <algorithm>
#include <utility>

#include "server/haptic_loop/haptic_loop.h"

namespace hapticd {

void HapticLoop::begin_scene() noexcept {
  HD_ASSERT(tool_count() >= 1 && tool_count() <= kMaxTools);
  time_.tick = 0;
  time_.period_ns = options_.period_ns;
  first_tick_ = true;
  image_due_ns_ = kNow;
  work_budget_ = scene_->work_budget;
  standing_fault_ = Cause::kNone;
  output_.tools.clear();
  output_.events.clear();
  output_.strings.clear();
  for (std::size_t k = 0; k < tool_count(); ++k) {
    tools_[k] = ToolLoop{};
    if (ToolTick* tick = output_.tools.append()) *tick = ToolTick{};
    HD_ASSERT(scene_->tools[k].device.device != nullptr);
    HapticDevice* device = scene_->tools[k].device.device;
    scene_->play.simulation->scene(k).stiffness_wanted = device->profile().affine;
    guarded_[k].store(device, std::memory_order_seq_cst);
  }
  const GesturePlan* gesture = scene_->gesture.get();
  if (gesture != nullptr) static_cast<void>(begin_gesture(*gesture));
}

// The guardian may be writing to the old scene's device at this moment; whoever frees it must not
// hear of it before that is over.
void HapticLoop::swap_scene() noexcept {
  for (auto& device : guarded_) device.store(nullptr, std::memory_order_seq_cst);
  if (change_ != nullptr) tell(SettingsRetired{change_.release()});
  for (SettingsChange* change : changes_) tell(SettingsRetired{change});
  changes_.clear();
  retired_ = std::exchange(scene_, std::move(waiting_));
  const bool latched = machine_.state == LoopState::kFault || machine_.ending;
  if (options_.virtual_time && !latched) machine_ = LoopMachine{};
  begin_scene();
  if (waiting_number_ != 0) tell(CommandDone{waiting_number_});
}

void HapticLoop::replace_scene(std::unique_ptr<PlayedScene> scene) noexcept {
  waiting_ = std::move(scene);
  waiting_number_ = 0;
  swap_scene();
  give_back_scene();
}

void HapticLoop::give_back_scene() noexcept {
  if (retired_ == nullptr || guarding_.load(std::memory_order_seq_cst)) return;
  tell(SceneSwapped{scene_->scene_id, retired_.release()});
}

void HapticLoop::take_scene(PlayedScene* scene, std::uint64_t number) noexcept {
  if (waiting_ != nullptr || retired_ != nullptr) {
    // One after the other is the sender's rule; here nothing may be lost.
    HD_ASSERT(false);
    return;
  }
  waiting_.reset(scene);
  waiting_number_ = number;
  if (options_.virtual_time) {
    swap_scene();
    give_back_scene();
  }
}

bool HapticLoop::begin_gesture(const GesturePlan& plan) noexcept {
  bool any = false;
  for (std::size_t k = 0; k < tool_count(); ++k) {
    SimulatedDevice* device = scene_->tools[k].device.simulated;
    if (device == nullptr) continue;
    any = true;
    static_cast<void>(device->recover());
    if (plan.arm) device->set_arm(*plan.arm);
    if (plan.seed) device->set_seed(*plan.seed + k);
    if (k >= plan.motions.size() || plan.motions[k].track().empty()) {
      device->stop_gesture();
    } else {
      device->play(plan.motions[k].track(), plan.repeat);
    }
  }
  return any;
}

void HapticLoop::play_gesture(GesturePlan* plan, std::uint64_t number) noexcept {
  if (!begin_gesture(*plan)) {
    tell(GestureRetired{plan});
    tell(CommandRefused{number, Cause::kNone});
    return;
  }
  tell(GestureRetired{scene_->gesture.release()});
  scene_->gesture.reset(plan);
  tell(CommandDone{number});
}

void HapticLoop::take_change(SettingsChange* change, std::uint64_t number) noexcept {
  // One for the scene before this one has come too late.
  change->number = number;
  if (change->to.pieces.size() != scene_->settings.pieces.size() ||
      change->to.tools.size() != scene_->settings.tools.size() || !changes_.push_back(change)) {
    tell(SettingsRetired{change, true});
    tell(CommandRefused{number, Cause::kNone});
    return;
  }
  tell(CommandDone{number});
}

// A new change begins where the one under way has come to.
void HapticLoop::follow_changes() noexcept {
  begun_change_ = 0;
  std::size_t kept = 0;
  for (std::size_t k = 0; k < changes_.size(); ++k) {
    SettingsChange* change = changes_[k];
    if (change->at_tick > time_.tick) {
      changes_[kept++] = change;
      continue;
    }
    if (change_ != nullptr) tell(SettingsRetired{change_.release()});
    change_.reset(change);
    begin_change(*scene_, *change_);
    change_share_ = 0.0;
    begun_change_ = change_->number;
  }
  changes_.truncate(kept);
  if (change_ == nullptr) return;
  change_share_ = std::min(change_share_ + time_.dt_s / kSettingsRamp_s, 1.0);
  follow_change(*change_, change_share_, *scene_);
  if (change_share_ >= 1.0) tell(SettingsRetired{change_.release()});
}

// A computed hand whose numbers have gone would be the cause for ever.
void HapticLoop::mend_devices() noexcept {
  if (machine_.state != LoopState::kFault) return;
  bool any = false;
  for (PlayedTool& tool : scene_->tools) {
    if (tool.device.simulated != nullptr) any = tool.device.simulated->recover() || any;
  }
  if (any && standing_fault_ == Cause::kNotFinite) standing_fault_ = Cause::kNone;
}

void HapticLoop::lose_lease(const LeaseLostCommand& lost) noexcept {
  leases_ended_ = lost.ended;
  std::size_t kept = 0;
  for (SettingsChange* change : changes_) {
    if (change->at_tick > time_.tick) {
      tell(SettingsRetired{change, true});
    } else {
      changes_[kept++] = change;
    }
  }
  changes_.truncate(kept);
  for (PlayedTool& tool : scene_->tools) {
    if (tool.device.scripted == nullptr) continue;
    tool.device.scripted->clear();
    lease_lost_ = true;
  }
}

}  // namespace hapticd
