// The order of a tick, commands and scenes. See haptic_loop.h. RT: yes.
#include "server/haptic_loop/haptic_loop.h"

#include <algorithm>
#include <utility>

#include "server/haptic_loop/thread_policy.h"

namespace hapticd {
namespace {

/// How long a Clear waits for a device to forget its fault, ns: many of its frames.
constexpr std::int64_t kClearWait_ns = 100'000'000;

/// Faults that a device latches itself.
bool latched_by_device(Cause cause) noexcept {
  return cause == Cause::kDeviceFault || cause == Cause::kDeviceWatchdog;
}

bool pushes_a_person(const PlayedTool& tool) noexcept {
  return can_push_a_person(tool.device.device->profile().driver);
}

/// Nothing touches and nothing pushes the tool.
bool is_contact_free(const RenderedTool& tool) noexcept {
  const Wrench& F = tool.F_computed_H_W;
  return tool.optimiser.active_count == 0 && tool.optimiser.status != ContactStatus::kRecovering &&
         F.f.isZero(0.0) && F.t.isZero(0.0);
}

/// The order that a command is, for those that the state machine hears.
std::uint16_t order_of(const LoopCommandBody& what) noexcept {
  if (std::holds_alternative<EngageCommand>(what)) return kOrderEngage;
  if (std::holds_alternative<DisengageCommand>(what)) return kOrderDisengage;
  if (std::holds_alternative<StopCommand>(what)) return kOrderStop;
  if (std::holds_alternative<ClearCommand>(what)) return kOrderClear;
  if (std::holds_alternative<EndCommand>(what)) return kOrderEnd;
  return 0;
}

}  // namespace

HapticLoop::HapticLoop(const LoopOptions& options, std::unique_ptr<PlayedScene> first,
                       LoopChannels& channels)
    : options_(options), channels_(channels), scene_(std::move(first)) {
  HD_ASSERT(scene_ != nullptr);
  begin_scene();
}

HapticLoop::~HapticLoop() = default;

void HapticLoop::obey(const LoopCommand& command) noexcept {
  if (std::holds_alternative<SwapSceneCommand>(command.what)) {
    take_scene(channels_.scenes.lent.pop(), command.number);
    return;
  }
  if (std::holds_alternative<PlayGestureCommand>(command.what)) {
    play_gesture(channels_.gestures.lent.pop(), command.number);
    return;
  }
  if (std::holds_alternative<ChangeSettingsCommand>(command.what)) {
    take_change(channels_.changes.lent.pop(), command.number);
    return;
  }
  if (std::holds_alternative<ClearCommand>(command.what)) mend_devices();
  if (const std::optional<Cause> refused = refusal_of(command.what)) {
    tell(CommandRefused{command.number, *refused});
    return;
  }
  if (const auto* recentre = std::get_if<RecentreCommand>(&command.what)) {
    if (recentre->tool < tool_count()) tools_[recentre->tool].recentre = true;
  } else if (const auto* clutch = std::get_if<ClutchCommand>(&command.what)) {
    if (clutch->tool < tool_count()) tools_[clutch->tool].clutch_open = clutch->open;
  } else if (const auto* push = std::get_if<PushCommand>(&command.what)) {
    if (push->tool < tool_count()) tools_[push->tool].push_asked = push->axis;
  } else if (const auto* budget = std::get_if<WorkBudgetCommand>(&command.what)) {
    work_budget_ = std::max<std::int64_t>(budget->work, 0);
  } else if (const auto* lost = std::get_if<LeaseLostCommand>(&command.what)) {
    lose_lease(*lost);
  } else {
    asked_ |= order_of(command.what);
    if ((asked_ & kOrderClear) != 0) clear_until_ns_ = time_.t_ns + kClearWait_ns;
  }
  tell(CommandDone{command.number});
}

std::optional<Cause> HapticLoop::refusal_of(const LoopCommandBody& what) const noexcept {
  const bool fault = machine_.state == LoopState::kFault;
  if (std::holds_alternative<EngageCommand>(what)) {
    if (fault) return machine_.cause;
    if (machine_.state == LoopState::kReady && !contact_free()) return Cause::kOverlap;
  }
  if (std::holds_alternative<PushCommand>(what) && machine_.state != LoopState::kEngaged) {
    return machine_.cause == Cause::kNone ? Cause::kReleased : machine_.cause;
  }
  if (std::holds_alternative<ClearCommand>(what) && fault) {
    const auto used = std::span(tools_).first(tool_count());
    const bool lost = std::any_of(used.begin(), used.end(),
                                  [](const ToolLoop& tool) { return tool.device_lost; });
    if (lost && machine_.cause == Cause::kDeviceLost) return Cause::kDeviceLost;
    if (standing_fault_ != Cause::kNone && !latched_by_device(standing_fault_)) {
      return standing_fault_;
    }
  }
  return std::nullopt;
}

void HapticLoop::take_commands() noexcept {
  LoopCommand command;
  for (int k = 0; k < kCommandsPerTick && channels_.commands.pop(command); ++k) obey(command);
  TickPose pose;
  for (int k = 0; k < kPosesPerTick && channels_.poses.pop(pose); ++k) {
    PoseQueue* poses =
        pose.tool < tool_count() ? scene_->tools[pose.tool].device.facets.poses : nullptr;
    if (poses == nullptr || pose.lease < leases_ended_) continue;
    poses->push(pose.tick, pose.pose);
    lease_lost_ = false;
  }
}

// All that comes from outside beside samples, in one place: what is noted here is recorded, and
// given back by a replay.
void HapticLoop::gather_orders() noexcept {
  const std::uint64_t stalls = stalls_.load(std::memory_order_relaxed);
  const std::uint64_t lost = channels_.events.overflow();
  unsigned orders = std::exchange(asked_, 0U);
  if (lease_lost_) orders |= kOrderLeaseLost;
  if (waiting_ != nullptr) orders |= kOrderSceneWaits;
  if (std::exchange(stalls_seen_, stalls) != stalls) orders |= kOrderStalled;
  if (std::exchange(events_overflow_, lost) != lost) orders |= kOrderEventLost;
  clear_devices();
  if (clear_until_ns_ > time_.t_ns) orders |= kOrderClear;
  orders_ = static_cast<std::uint16_t>(orders);
  for (ToolLoop& tool : tools()) tool.recentre_asked = tool.recentre;
}

// A device forgets only when it is told to, and says so a tick or two later; Clear waits for that.
void HapticLoop::clear_devices() noexcept {
  const bool fault = machine_.state == LoopState::kFault;
  if (!fault) clear_until_ns_ = kNow;
  for (ToolLoop& tool : tools()) {
    constexpr unsigned kLatched = kDeviceReportsFault | kDeviceWatchdogFired;
    tool.clear_faults = clear_until_ns_ > time_.t_ns && (tool.sample.flags & kLatched) != 0;
  }
}

void HapticLoop::read_devices() noexcept {
  bool learned = false;
  for (std::size_t k = 0; k < tool_count(); ++k) {
    read_tool(scene_->tools[k], time_, options_.guards_armed, tools_[k]);
    learned = learn_delay(tools_[k].sample, scene_->tools[k]) || learned;
  }
  if (learned) apply_settings(*scene_);
}

bool HapticLoop::all_have_poses() const noexcept {
  return std::all_of(tools_.begin(), tools_.begin() + static_cast<std::ptrdiff_t>(tool_count()),
                     [](const ToolLoop& tool) { return tool.guard.has_pose; });
}

bool HapticLoop::contact_free() const noexcept {
  return std::all_of(tools_.begin(), tools_.begin() + static_cast<std::ptrdiff_t>(tool_count()),
                     [](const ToolLoop& tool) { return tool.contact_free; });
}

void HapticLoop::blame(Cause cause, std::size_t tool) noexcept {
  if (cause == Cause::kNone || loop_input_.fault != Cause::kNone) return;
  loop_input_.fault = cause;
  blamed_ = tool;
}

// What a stall makes of the devices, such as a watchdog that fires, is not its cause.
void HapticLoop::find_faults() noexcept {
  const bool any_pushes = std::any_of(scene_->tools.begin(), scene_->tools.end(), pushes_a_person);
  const auto of_the_loop = [&](bool wrong, Cause cause) {
    if (wrong && latches(cause, any_pushes, options_.guards_armed)) blame(cause, 0);
  };
  of_the_loop((orders_ & kOrderStalled) != 0, Cause::kGuardian);
  for (std::size_t k = 0; k < tool_count(); ++k) {
    blame(fault_of(tools_[k], pushes_a_person(scene_->tools[k]), options_.guards_armed), k);
  }
  of_the_loop((orders_ & kOrderEventLost) != 0, Cause::kEventOverflow);
  of_the_loop(late_, Cause::kOverrun);
  standing_fault_ = loop_input_.fault;
}

void HapticLoop::advance_state() noexcept {
  LoopInput& input = loop_input_;
  input = LoopInput{};
  const auto has = [this](OrderBit order) { return (orders_ & order) != 0; };
  input.dt_s = time_.dt_s;
  input.attached = true;
  input.calibrated = true;
  input.engages_itself = true;
  for (std::size_t k = 0; k < tool_count(); ++k) {
    const ToolLoop& tool = tools_[k];
    if (tool.device_lost || (tool.sample.flags & kDeviceAttached) == 0) input.attached = false;
    if ((tool.sample.flags & kDeviceCalibrated) == 0) input.calibrated = false;
    if (can_push_a_person(scene_->tools[k].device.device->profile().driver)) {
      input.engages_itself = false;
    }
    if ((tool.sample.flags & kDeviceDeadManOpen) != 0) input.block = Cause::kDeadMan;
  }
  input.contact_free = contact_free();
  input.lease_lost = has(kOrderLeaseLost);
  input.scene_waits = has(kOrderSceneWaits);
  input.engage = has(kOrderEngage);
  input.disengage = has(kOrderDisengage);
  input.stop = has(kOrderStop);
  input.clear = has(kOrderClear);
  input.end = has(kOrderEnd);
  find_faults();
  const LoopState before = machine_.state;
  loop_output_ = advance(input, machine_);
  if (machine_.state != before) {
    channels_.log.push(make_log_record<LogCode::kLoopStateChanged>(
        time_.t_ns, static_cast<int>(before), static_cast<int>(machine_.state)));
  }
  for (ToolLoop& tool : tools()) {
    if (follow_push(tool.push_asked, machine_.state, time_.dt_s, tool.push)) tool.safety.port = {};
  }
  if (loop_output_.latched || loop_output_.cleared) {
    tell(FaultNotice{loop_output_.cause, loop_output_.latched}, blamed_);
  }
  if (loop_output_.latched) {
    channels_.log.push(make_log_record<LogCode::kFaultLatched>(
        time_.t_ns, static_cast<int>(loop_output_.cause), time_.tick));
  }
  blamed_ = 0;
}

// What cannot be used is not computed with: the last good pose again, at its own time, lets the
// simulation stand still.
void HapticLoop::render() noexcept {
  for (ToolLoop& tool : tools()) {
    tool.F_H_D = Wrench{};
    tool.wanted = DeviceSpring{};
  }
  if (!all_have_poses()) {
    // Of a pose that was forgotten nothing is told any more.
    for (RenderedTool& tool : output_.tools) tool = RenderedTool{};
    output_.strings.clear();
    return;
  }
  TickInput input;
  input.work_budget = work_budget_;
  for (std::size_t k = 0; k < tool_count(); ++k) {
    const Pose& X_WH = tools_[k].placed.X_WH;
    input.hands[k] = {tools_[k].judged.t_ns, to_array(X_WH.p), to_array(X_WH.q)};
  }
  Simulation& simulation = *scene_->play.simulation;
  simulation.step(input, output_);
  for (std::size_t k = 0; k < tool_count(); ++k) {
    ToolLoop& tool = tools_[k];
    const PlayedTool& played = scene_->tools[k];
    const double gain = played.force_gain * tool.placed.wrench_share;
    const Wrench& F_H_W = output_.tools[k].F_H_W;
    tool.contact_free = is_contact_free(output_.tools[k]);
    tool.F_H_D =
        with_push(tool.push, to_device(played.map, Wrench{F_H_W.f * gain, F_H_W.t * gain}));
    const bool wanted = simulation.scene(k).stiffness_wanted && tool.push.axis == 0;
    if (wanted) tool.wanted = spring_at_device(played.map, output_.tools[k].stiffness, gain);
  }
}

void HapticLoop::limit_wrenches() noexcept {
  const bool force =
      machine_.state == LoopState::kEngaged || machine_.state == LoopState::kReleasing;
  const Simulation& simulation = *scene_->play.simulation;
  bool enabled = false;
  for (std::size_t k = 0; k < tool_count(); ++k) {
    limit_tool(scene_->tools[k], time_, simulation.tank_energy(k), loop_output_.gain, force,
               tools_[k]);
    enabled = enabled || tools_[k].written.enable;
  }
  force_on_.store(enabled && !options_.virtual_time, std::memory_order_relaxed);
}

void HapticLoop::write_devices() noexcept {
  for (std::size_t k = 0; k < tool_count(); ++k) write_tool(scene_->tools[k], time_, tools_[k]);
}

// One line a second says as much as one per tick.
void HapticLoop::report_late(std::uint64_t skipped) noexcept {
  late_skipped_ += skipped;
  if (late_skipped_ == 0 || time_.t_ns - late_told_ns_ < kLateWindow_ns) return;
  channels_.log.push(make_log_record<LogCode::kTickLate>(
      time_.t_ns, time_.tick, static_cast<std::int64_t>(late_skipped_) * options_.period_ns,
      late_skipped_));
  late_skipped_ = 0;
  late_told_ns_ = time_.t_ns;
}

void HapticLoop::tick_once(std::int64_t now_ns, std::uint64_t skipped) noexcept {
  heartbeat_ns_.store(options_.virtual_time ? 0 : now_ns, std::memory_order_relaxed);
  take_commands();
  give_back_scene();
  gather_orders();
  pass(now_ns, skipped);
}

void HapticLoop::pass(std::int64_t now_ns, std::uint64_t skipped) noexcept {
  skipped_ = skipped;
  time_.tick += skipped;
  const std::int64_t before_ns = time_.t_ns;
  time_.t_ns =
      options_.virtual_time ? static_cast<std::int64_t>(time_.tick) * options_.period_ns : now_ns;
  time_.dt_ns = first_tick_ ? 0 : time_.t_ns - before_ns;
  time_.dt_s = 1e-9 * static_cast<double>(time_.dt_ns);
  first_tick_ = false;
  times_.overruns += skipped;
  late_ = watch_overrun(skipped > 0, time_.t_ns, overrun_watch_);
  report_late(skipped);

  StageClock* const clock = stage_clock();
  const std::uint32_t published_ns = clock_.times()[static_cast<std::size_t>(Stage::kPublish)];
  clock_.start(now_ns);
  follow_changes();
  read_devices();
  advance_state();
  lap(clock, Stage::kRead);
  render();
  limit_wrenches();
  lap(clock, Stage::kSafety);
  write_devices();
  lap(clock, Stage::kWrite);
  times_.stages = clock_.times();
  times_.stages[static_cast<std::size_t>(Stage::kPublish)] = published_ns;
  report_events();
  publish_tick();
  publish_snapshot();
  for (ToolLoop& tool : tools()) tool.push_asked = 0;
  ever_ticked_ = true;
  ++time_.tick;
  // The zero wrench of this tick was the last that the old scene's device gets.
  if (loop_output_.scene_allowed && waiting_ != nullptr) swap_scene();
  if (options_.virtual_time) return;
  clock_.lap(Stage::kPublish);
  const std::int64_t cpu_ns = thread_cpu_ns();
  times_.cpu_ns = cpu_before_ns_ == 0 ? 0 : static_cast<std::uint32_t>(cpu_ns - cpu_before_ns_);
  cpu_before_ns_ = cpu_ns;
}

void HapticLoop::guard(std::int64_t now_ns) noexcept {
  const bool armed = force_on_.load(std::memory_order_relaxed);
  if (!must_write_zero(heartbeat_ns_.load(std::memory_order_relaxed), now_ns, armed, guardian_)) {
    return;
  }
  guarding_.store(true, std::memory_order_seq_cst);
  for (auto& guarded : guarded_) {
    HapticDevice* device = guarded.load(std::memory_order_seq_cst);
    if (device != nullptr) device->write_zero(now_ns);
  }
  guarding_.store(false, std::memory_order_seq_cst);
  stalls_.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace hapticd
