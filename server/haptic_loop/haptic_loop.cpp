// The order of a tick, commands and scenes. See haptic_loop.h. RT: yes.
#include "server/haptic_loop/haptic_loop.h"

#include <algorithm>
#include <ctime>
#include <utility>

#include "core/rt/monotonic_clock.h"

namespace hapticd {
namespace {

/// A pose that repeats to the bit for so long under force is a stuck sensor, ns (InputLimits).
constexpr std::int64_t kStuckAfter_ns = 250'000'000;

std::int64_t thread_cpu_ns() noexcept {
  timespec used{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
  return std::int64_t{used.tv_sec} * 1'000'000'000 + used.tv_nsec;
}

std::uint32_t span_ns(std::int64_t from_ns, std::int64_t to_ns) noexcept {
  return static_cast<std::uint32_t>(to_ns - from_ns);
}

/// Nothing touches and nothing pushes, as far as the last tick knew.
bool contact_free(const TickOutput& output) noexcept {
  if (output.tools.empty()) return false;
  const ToolTick& tool = output.tools[0];
  const Wrench& F = tool.F_unlimited_H_W;
  return tool.pose != PoseVerdict::kFault && tool.optimiser.active_count == 0 &&
         tool.optimiser.status != OptimiserStatus::kRecovering && F.f.isZero(0.0) &&
         F.t.isZero(0.0);
}

}  // namespace

HapticLoop::HapticLoop(const LoopOptions& options, std::unique_ptr<PlayedScene> first,
                       LoopChannels& channels)
    : options_(options), channels_(channels), scene_(std::move(first)) {
  HD_ASSERT(scene_ != nullptr && scene_->device.device != nullptr);
  begin_scene();
}

HapticLoop::~HapticLoop() {
  for (SettingsChange* change : changes_) delete change;
}

void HapticLoop::begin_scene() noexcept {
  tick_ = 0;
  first_tick_ = true;
  input_watch_ = InputWatch{};
  safety_ = SafetyState{};
  workspace_ = WorkspaceState{};
  clutch_open_ = false;
  recentre_ = false;
  standing_fault_ = Cause::kNone;
  written_ = SafetyOutput{};
  touches_ = TouchDetector{};
  sample_ = DeviceSample{};
  output_.tools.clear();
  if (ToolTick* tool = output_.tools.append()) *tool = ToolTick{};
  output_.events.clear();
  output_.strings.clear();
  contacts_.contacts.clear();
  contacts_.total = 0;
  device_lost_ = false;
  write_failed_ = false;
  wrench_not_finite_ = false;
  guarded_.store(scene_->device.device, std::memory_order_seq_cst);
  const GesturePlan* gesture = scene_->gesture.get();
  if (gesture != nullptr && scene_->device.simulated != nullptr) {
    if (gesture->arm) scene_->device.simulated->set_arm(*gesture->arm);
    if (gesture->seed) scene_->device.simulated->set_seed(*gesture->seed);
    scene_->device.simulated->play(gesture->motion.track(), gesture->repeat);
  }
}

// The guardian may be writing to the old scene's device at this moment; whoever frees it must not
// hear of it before that is over.
void HapticLoop::swap_scene() noexcept {
  guarded_.store(nullptr, std::memory_order_seq_cst);
  if (change_ != nullptr) tell(SettingsRetired{change_.release()});
  for (SettingsChange* change : changes_) tell(SettingsRetired{change});
  changes_.clear();
  retired_ = std::exchange(scene_, std::move(waiting_));
  const bool latched = machine_.state == LoopState::kFault || machine_.ending;
  if (options_.virtual_time && !latched) machine_ = LoopMachine{};
  begin_scene();
  tell(CommandDone{waiting_number_});
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

void HapticLoop::play_gesture(GesturePlan* plan, std::uint64_t number) noexcept {
  SimulatedDevice* device = scene_->device.simulated;
  if (device == nullptr) {
    tell(GestureRetired{plan});
    tell(CommandRefused{number, Cause::kNone});
    return;
  }
  if (plan->arm) device->set_arm(*plan->arm);
  if (plan->seed) device->set_seed(*plan->seed);
  if (plan->motion.track().empty()) {
    device->stop_gesture();
  } else {
    device->play(plan->motion.track(), plan->repeat);
  }
  tell(GestureRetired{scene_->gesture.release()});
  scene_->gesture.reset(plan);
  tell(CommandDone{number});
}

void HapticLoop::take_change(SettingsChange* change, std::uint64_t number) noexcept {
  // One for the scene before this one has come too late.
  if (change->to.pieces.size() != scene_->settings.pieces.size() || !changes_.push_back(change)) {
    tell(SettingsRetired{change});
    tell(CommandRefused{number, Cause::kNone});
    return;
  }
  tell(CommandDone{number});
}

// A new change begins where the one under way has come to.
void HapticLoop::follow_changes() noexcept {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < changes_.size(); ++k) {
    SettingsChange* change = changes_[k];
    if (change->at_tick > tick_) {
      changes_[kept++] = change;
      continue;
    }
    if (change_ != nullptr) tell(SettingsRetired{change_.release()});
    change_.reset(change);
    begin_change(*scene_, *change_);
    change_share_ = 0.0;
  }
  changes_.truncate(kept);
  if (change_ == nullptr) return;
  change_share_ = std::min(change_share_ + dt_s_ / kSettingsRamp_s, 1.0);
  follow_change(*change_, change_share_, *scene_);
  if (change_share_ >= 1.0) tell(SettingsRetired{change_.release()});
}

void HapticLoop::obey(const LoopCommand& command) noexcept {
  if (const auto* swap = std::get_if<SwapSceneCommand>(&command.what)) {
    take_scene(swap->scene, command.number);
    return;
  }
  if (const auto* play = std::get_if<PlayGestureCommand>(&command.what)) {
    play_gesture(play->plan, command.number);
    return;
  }
  if (const auto* change = std::get_if<ChangeSettingsCommand>(&command.what)) {
    take_change(change->change, command.number);
    return;
  }
  const bool fault = machine_.state == LoopState::kFault;
  if (std::holds_alternative<EngageCommand>(command.what)) {
    const Cause why = fault ? machine_.cause : Cause::kOverlap;
    if (fault || (machine_.state == LoopState::kReady && !contact_free(output_))) {
      tell(CommandRefused{command.number, why});
      return;
    }
    loop_input_.engage = true;
  } else if (std::holds_alternative<DisengageCommand>(command.what)) {
    loop_input_.disengage = true;
  } else if (std::holds_alternative<StopCommand>(command.what)) {
    loop_input_.stop = true;
  } else if (std::holds_alternative<ClearCommand>(command.what)) {
    const bool gone = device_lost_ && machine_.cause == Cause::kDeviceLost;
    if (fault && (gone || standing_fault_ != Cause::kNone)) {
      tell(CommandRefused{command.number, gone ? Cause::kDeviceLost : standing_fault_});
      return;
    }
    loop_input_.clear = true;
  } else if (std::holds_alternative<EndCommand>(command.what)) {
    loop_input_.end = true;
  } else if (std::holds_alternative<LeaseLostCommand>(command.what)) {
    if (scene_->device.scripted != nullptr) {
      scene_->device.scripted->clear();
      lease_lost_ = true;
    }
  } else if (std::holds_alternative<RecentreCommand>(command.what)) {
    recentre_ = true;
  } else if (const auto* clutch = std::get_if<ClutchCommand>(&command.what)) {
    clutch_open_ = clutch->open;
  }
  tell(CommandDone{command.number});
}

void HapticLoop::take_commands() noexcept {
  LoopCommand command;
  for (int k = 0; k < kCommandsPerTick && channels_.commands.pop(command); ++k) obey(command);
  TickPose pose;
  for (int k = 0; k < kPosesPerTick && channels_.poses.pop(pose); ++k) {
    if (scene_->device.scripted == nullptr) continue;
    scene_->device.scripted->push(pose.tick, pose.pose);
    lease_lost_ = false;
  }
}

void HapticLoop::read_device() noexcept {
  PlayedDevice& device = scene_->device;
  if (device.scripted != nullptr) device.scripted->set_tick(tick_);
  const ReadOutcome outcome = device.device->read(t_ns_, sample_);
  device_lost_ = outcome == ReadOutcome::kLost;
  sample_came_ = outcome == ReadOutcome::kFresh;
  WatchedSample seen;
  seen.fresh = outcome == ReadOutcome::kFresh;
  seen.t_ns = sample_.t_ns;
  seen.counter = sample_.counter;
  seen.p_DH = sample_.p_DH;
  seen.q_DH = sample_.q_DH;
  seen.has_velocity = sample_.has_velocity;
  seen.v_DH_D = sample_.v_DH_D;
  seen.w_DH_D = sample_.w_DH_D;
  const DeviceProfile& profile = device.device->profile();
  InputLimits limits;
  limits.velocity_trip = profile.velocity_trip;
  limits.stale_ticks =
      bridged_ticks(profile.report_rate, 1e9 / static_cast<double>(options_.period_ns));
  const bool watched = can_push_a_person(profile.driver) || options_.guards_armed;
  limits.stuck_after_ns = watched ? kStuckAfter_ns : 0;
  watched_ = watch(seen, to_vector(safety_.f_H_D).norm(), limits, input_watch_);
  if (!input_watch_.has_pose) return;
  placed_ =
      follow(scene_->map, scene_->X_WG_home,
             {watched_.X_DH, watched_.V_DH_D, sample_.buttons, clutch_open_, recentre_, dt_s_},
             workspace_);
  recentre_ = false;
}

void HapticLoop::advance_state() noexcept {
  const DeviceProfile& profile = scene_->device.device->profile();
  const bool pushes = can_push_a_person(profile.driver);
  LoopInput& input = loop_input_;
  input.dt_s = dt_s_;
  input.attached = !device_lost_ && (sample_.flags & kDeviceAttached) != 0;
  input.calibrated = (sample_.flags & kDeviceCalibrated) != 0;
  input.contact_free = contact_free(output_);
  input.engages_itself = !pushes;
  input.lease_lost = lease_lost_;
  input.scene_waits = waiting_ != nullptr;
  const std::uint64_t stalls = stalls_.load(std::memory_order_relaxed);
  const auto blame = [&](bool wrong, Cause cause) {
    if (wrong && input.fault == Cause::kNone && latches(cause, pushes, options_.guards_armed)) {
      input.fault = cause;
    }
  };
  blame(watched_.fault != Cause::kNone, watched_.fault);
  blame(wrench_not_finite_, Cause::kNotFinite);
  blame(write_failed_, Cause::kDeviceWrite);
  blame(channels_.events.overflow() != events_overflow_, Cause::kEventOverflow);
  blame(stalls != stalls_seen_, Cause::kGuardian);
  blame(late_, Cause::kOverrun);
  blame((sample_.flags & kDeviceEmergencyStop) != 0, Cause::kEmergencyStop);
  blame((sample_.flags & kDeviceReportsFault) != 0, Cause::kDeviceFault);
  standing_fault_ = input.fault;
  stalls_seen_ = stalls;
  events_overflow_ = channels_.events.overflow();

  const LoopState before = machine_.state;
  loop_output_ = advance(input, machine_);
  loop_input_ = LoopInput{};
  if (machine_.state != before) {
    channels_.log.push(make_log_record<LogCode::kLoopStateChanged>(
        t_ns_, static_cast<int>(before), static_cast<int>(machine_.state)));
  }
  if (loop_output_.latched || loop_output_.cleared) {
    tell(FaultNotice{loop_output_.cause, loop_output_.latched});
  }
  if (loop_output_.latched) {
    channels_.log.push(make_log_record<LogCode::kFaultLatched>(
        t_ns_, static_cast<int>(loop_output_.cause), tick_));
  }
}

// What cannot be used is not computed with: the last good pose again, at its own time, lets the
// simulation stand still.
void HapticLoop::render() noexcept {
  F_H_D_ = Wrench{};
  if (!input_watch_.has_pose) return;
  const Pose& X_WH = placed_.X_WH;
  const TickInput input = input_of({input_watch_.t_ns, to_array(X_WH.p), to_array(X_WH.q)});
  Simulation& simulation = *scene_->play.simulation;
  simulation.step(input, output_);
  if (options_.contacts_reported) simulation.report_contacts(0, contacts_);
  const double gain = scene_->force_gain * placed_.wrench_share;
  const Wrench& F_H_W = output_.tools[0].F_H_W;
  F_H_D_ = to_device(scene_->map, Wrench{F_H_W.f * gain, F_H_W.t * gain});
}

void HapticLoop::write_device() noexcept {
  SafetyInput input;
  input.now_ns = t_ns_;
  input.dt_s = dt_s_;
  input.hold_s = 1e-9 * static_cast<double>(options_.period_ns);
  input.enable = watched_.usable &&
                 (machine_.state == LoopState::kEngaged || machine_.state == LoopState::kReleasing);
  input.gain = loop_output_.gain;
  input.F_H_D = F_H_D_;
  input.V_DH_D = watched_.V_DH_D;
  input.displacement_D = watched_.displacement_D;
  input.budget = scene_->play.simulation->tank_energy() / scene_->map.scale;
  written_ = limit(input, scene_->limits, safety_);
  wrench_not_finite_ = (written_.flags & kSafetyNotFinite) != 0;
  DeviceCommand command;
  command.f_H_D = written_.f_H_D;
  command.t_H_D = written_.t_H_D;
  command.enable = written_.enable;
  command.expires_ns = written_.expires_ns;
  command.sample_counter = sample_.counter;
  force_on_.store(written_.enable && !options_.virtual_time, std::memory_order_relaxed);
  write_failed_ = !scene_->device.device->write(t_ns_, command) && !device_lost_;
}

// One line a second says as much as one per tick.
void HapticLoop::report_late(std::uint64_t skipped) noexcept {
  late_skipped_ += skipped;
  if (late_skipped_ == 0 || t_ns_ - late_told_ns_ < kLateWindow_ns) return;
  channels_.log.push(make_log_record<LogCode::kTickLate>(
      t_ns_, tick_, static_cast<std::int64_t>(late_skipped_) * options_.period_ns, late_skipped_));
  late_skipped_ = 0;
  late_told_ns_ = t_ns_;
}

void HapticLoop::tick_once(std::int64_t now_ns, std::uint64_t skipped) noexcept {
  const std::int64_t began_ns = options_.virtual_time ? 0 : now_ns;
  heartbeat_ns_.store(began_ns, std::memory_order_relaxed);
  take_commands();
  give_back_scene();
  tick_ += skipped;
  const std::int64_t before_ns = t_ns_;
  t_ns_ = options_.virtual_time ? static_cast<std::int64_t>(tick_) * options_.period_ns : now_ns;
  dt_ns_ = first_tick_ ? 0 : t_ns_ - before_ns;
  dt_s_ = 1e-9 * static_cast<double>(dt_ns_);
  first_tick_ = false;
  timing_.overruns += skipped;
  late_ = watch_overrun(skipped > 0, t_ns_, overrun_watch_);
  report_late(skipped);

  follow_changes();
  const auto clock = [&] { return options_.virtual_time ? 0 : monotonic_now_ns(); };
  read_device();
  const std::int64_t read_ns = clock();
  advance_state();
  render();
  const std::int64_t rendered_ns = clock();
  write_device();
  const std::int64_t written_ns = clock();
  timing_.read_ns = span_ns(began_ns, read_ns);
  timing_.simulation_ns = span_ns(read_ns, rendered_ns);
  timing_.write_ns = span_ns(rendered_ns, written_ns);
  report_events();
  publish_snapshot();
  publish_trace();
  ++tick_;
  // The zero wrench of this tick was the last that the old scene's device gets.
  if (loop_output_.scene_allowed && waiting_ != nullptr) swap_scene();
  if (options_.virtual_time) return;
  timing_.publish_ns = span_ns(written_ns, clock());
  const std::int64_t cpu_ns = thread_cpu_ns();
  timing_.cpu_ns = span_ns(cpu_before_ns_, cpu_ns);
  cpu_before_ns_ = cpu_ns;
}

void HapticLoop::guard(std::int64_t now_ns) noexcept {
  const bool armed = force_on_.load(std::memory_order_relaxed);
  if (!must_write_zero(heartbeat_ns_.load(std::memory_order_relaxed), now_ns, armed, guardian_)) {
    return;
  }
  guarding_.store(true, std::memory_order_seq_cst);
  HapticDevice* device = guarded_.load(std::memory_order_seq_cst);
  if (device != nullptr) device->write_zero(now_ns);
  guarding_.store(false, std::memory_order_seq_cst);
  stalls_.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace hapticd
