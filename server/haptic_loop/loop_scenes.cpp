// Scenes, gestures and settings of the loop: taken, begun, given back; what a lost lease takes with
// it, and what Clear mends. See haptic_loop.h. RT: yes.
#include <algorithm>
#include <utility>

#include "server/haptic_loop/haptic_loop.h"

namespace hapticd {
namespace {

/// Gives back what is not touched any more; there is room, since whoever lends counts.
template <typename Ring, typename Owner>
void give_back(Owner owner, Ring& ring) noexcept {
  if (owner == nullptr) return;
  const bool has_room = ring.push(owner);
  HD_ASSERT(has_room);
}

}  // namespace

void HapticLoop::begin_scene() noexcept {
  HD_ASSERT(tool_count() >= 1 && tool_count() <= kMaxTools);
  time_.tick = 0;
  time_.period_ns = options_.period_ns;
  first_tick_ = true;
  snapshot_due_ns_ = kNow;
  work_budget_ = scene_->work_budget;
  standing_fault_ = Cause::kNone;
  output_.tools.clear();
  output_.events.clear();
  output_.strings.clear();
  for (std::size_t k = 0; k < tool_count(); ++k) {
    tools_[k] = ToolLoop{};
    if (RenderedTool* tick = output_.tools.append()) *tick = RenderedTool{};
    HD_ASSERT(scene_->tools[k].device.device != nullptr);
    HapticDevice* device = scene_->tools[k].device.device;
    ToolScene& scene = scene_->play.simulation->scene(k);
    scene.stiffness_wanted = device->profile().affine;
    scene.clock = stage_clock();
    guarded_[k].store(device, std::memory_order_seq_cst);
  }
  const GesturePlan* gesture = scene_->gesture.get();
  if (gesture != nullptr) static_cast<void>(begin_gesture(*gesture));
}

// The guardian may be writing to the old scene's device at this moment; whoever frees it must not
// hear of it before that is over.
void HapticLoop::swap_scene() noexcept {
  for (auto& device : guarded_) device.store(nullptr, std::memory_order_seq_cst);
  retire(std::move(change_));
  for (std::size_t k = 0; k < waiting_changes_; ++k) retire(std::move(changes_[k]));
  waiting_changes_ = 0;
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
  give_back(std::move(retired_), channels_.scenes.back);
  tell(SceneSwapped{scene_->scene_id});
}

void HapticLoop::take_scene(std::unique_ptr<PlayedScene> scene, std::uint64_t number) noexcept {
  // One after the other is the sender's rule.
  HD_ASSERT(scene != nullptr && waiting_ == nullptr && retired_ == nullptr);
  waiting_ = std::move(scene);
  waiting_number_ = number;
  if (options_.virtual_time) {
    swap_scene();
    give_back_scene();
  }
}

bool HapticLoop::begin_gesture(const GesturePlan& plan) noexcept {
  bool any = false;
  for (std::size_t k = 0; k < tool_count(); ++k) {
    GestureHand* hand = scene_->tools[k].device.facets.hand;
    if (hand == nullptr) continue;
    any = true;
    static_cast<void>(hand->recover());
    if (plan.arm) hand->set_arm(*plan.arm);
    if (plan.seed) hand->set_seed(*plan.seed + k);
    if (k >= plan.motions.size() || plan.motions[k].track().empty()) {
      hand->stop_gesture();
    } else {
      hand->play(plan.motions[k].track(), plan.repeat);
    }
  }
  return any;
}

void HapticLoop::play_gesture(std::unique_ptr<GesturePlan> plan, std::uint64_t number) noexcept {
  HD_ASSERT(plan != nullptr);
  if (!begin_gesture(*plan)) {
    give_back(std::move(plan), channels_.gestures.back);
    tell(CommandRefused{number, Cause::kNone});
    return;
  }
  give_back(std::exchange(scene_->gesture, std::move(plan)), channels_.gestures.back);
  tell(CommandDone{number});
}

void HapticLoop::retire(std::unique_ptr<SettingsChange> change, bool dropped) noexcept {
  if (change == nullptr) return;
  tell(SettingsRetired{change->number, dropped});
  give_back(std::move(change), channels_.changes.back);
}

void HapticLoop::take_change(std::unique_ptr<SettingsChange> change,
                             std::uint64_t number) noexcept {
  HD_ASSERT(change != nullptr);
  change->number = number;
  // One for the scene before this one has come too late.
  if (change->to.pieces.size() != scene_->settings.pieces.size() ||
      change->to.tools.size() != scene_->settings.tools.size() ||
      waiting_changes_ == changes_.size()) {
    retire(std::move(change), true);
    tell(CommandRefused{number, Cause::kNone});
    return;
  }
  changes_[waiting_changes_++] = std::move(change);
  tell(CommandDone{number});
}

// A new change begins where the one under way has come to.
void HapticLoop::follow_changes() noexcept {
  begun_change_ = 0;
  std::size_t kept = 0;
  for (std::size_t k = 0; k < waiting_changes_; ++k) {
    std::unique_ptr<SettingsChange> change = std::move(changes_[k]);
    if (change->at_tick > time_.tick) {
      changes_[kept++] = std::move(change);
      continue;
    }
    retire(std::move(change_));
    change_ = std::move(change);
    begin_change(*scene_, *change_);
    change_share_ = 0.0;
    begun_change_ = change_->number;
  }
  waiting_changes_ = kept;
  if (change_ == nullptr) return;
  change_share_ = std::min(change_share_ + time_.dt_s / kSettingsRamp_s, 1.0);
  follow_change(*change_, change_share_, *scene_);
  if (change_share_ >= 1.0) retire(std::move(change_));
}

// A computed hand whose numbers have gone would be the cause for ever.
void HapticLoop::mend_devices() noexcept {
  if (machine_.state != LoopState::kFault) return;
  bool any = false;
  for (PlayedTool& tool : scene_->tools) {
    GestureHand* hand = tool.device.facets.hand;
    if (hand != nullptr) any = hand->recover() || any;
  }
  if (any && standing_fault_ == Cause::kNotFinite) standing_fault_ = Cause::kNone;
}

void HapticLoop::lose_lease(const LeaseLostCommand& lost) noexcept {
  leases_ended_ = lost.ended;
  std::size_t kept = 0;
  for (std::size_t k = 0; k < waiting_changes_; ++k) {
    std::unique_ptr<SettingsChange> change = std::move(changes_[k]);
    if (change->at_tick > time_.tick) {
      retire(std::move(change), true);
    } else {
      changes_[kept++] = std::move(change);
    }
  }
  waiting_changes_ = kept;
  for (PlayedTool& tool : scene_->tools) {
    PoseQueue* poses = tool.device.facets.poses;
    if (poses == nullptr) continue;
    poses->clear();
    lease_lost_ = true;
  }
}

}  // namespace hapticd
