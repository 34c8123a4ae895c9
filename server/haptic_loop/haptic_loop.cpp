// The order of a tick. See haptic_loop.h. RT: yes.
#include "server/haptic_loop/haptic_loop.h"

#include <algorithm>
#include <utility>

#include "server/haptic_loop/thread_policy.h"

namespace hapticd {
namespace {

/// Time between two snapshots, ns. Longer: a replay of the last minute begins later in it.
constexpr std::int64_t kSnapshotEvery_ns = 1'000'000'000;

/// Faults that a device latches itself.
bool latched_by_device(Cause cause) noexcept {
  return cause == Cause::kDeviceFault || cause == Cause::kDeviceWatchdog;
}

bool pushes_a_person(const PlayedTool& tool) noexcept {
  return tool.device.traits.can_push_a_person;
}

/// The simulated hands play `plan`; false when there is none.
bool begin_gesture(const GesturePlan& plan, PlayedScene& scene) noexcept {
  bool any = false;
  for (std::size_t k = 0; k < scene.tools.size(); ++k) {
    GestureHand* hand = scene.tools[k].device.facets.hand;
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

}  // namespace

HapticLoop::HapticLoop(const LoopOptions& options, std::unique_ptr<PlayedScene> first,
                       LoopChannels& channels)
    : options_(options), channels_(channels), scenes_(std::move(first)) {
  tick_.first = true;
  begin_scene();
}

void HapticLoop::take_commands() noexcept {
  LoopCommand command;
  for (int k = 0; k < kCommandsPerTick && channels_.commands.pop(command); ++k) obey(command);
  TickPose pose;
  for (int k = 0; k < kPosesPerTick && channels_.poses.pop(pose); ++k) {
    PoseQueue* poses =
        pose.tool < tool_count() ? scene().tools[pose.tool].device.facets.poses : nullptr;
    if (poses == nullptr || !orders_.take_pose(pose.lease)) continue;
    poses->push(pose.tick, pose.pose);
  }
}

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
    publisher_.tell(CommandRefused{command.number, *refused});
    return;
  }
  if (const auto* budget = std::get_if<WorkBudgetCommand>(&command.what)) {
    tick_.budget.work = static_cast<std::uint64_t>(std::max<std::int64_t>(budget->work, 0));
  } else if (const auto* lost = std::get_if<LeaseLostCommand>(&command.what)) {
    lose_lease(*lost);
  } else {
    obey_tool(command.what);
    orders_.ask(command.what, kept_.time.t_ns);
    if (std::holds_alternative<ClearCommand>(command.what)) channels_.stop.note_clear();
  }
  publisher_.tell(CommandDone{command.number});
}

void HapticLoop::obey_tool(const LoopCommandBody& what) noexcept {
  const auto of = [this](std::uint32_t tool) {
    return tool < tool_count() ? &kept_.tools[tool] : nullptr;
  };
  if (const auto* recentre = std::get_if<RecentreCommand>(&what)) {
    if (ToolLoop* tool = of(recentre->tool)) tool->asked.recentre = true;
  } else if (const auto* clutch = std::get_if<ClutchCommand>(&what)) {
    if (ToolLoop* tool = of(clutch->tool)) tool->asked.clutch_open = clutch->open;
  } else if (const auto* push = std::get_if<PushCommand>(&what)) {
    if (ToolLoop* tool = of(push->tool)) tool->asked.push = push->axis;
  } else if (const auto* measure = std::get_if<MeasureCommand>(&what)) {
    if (ToolLoop* tool = of(measure->tool)) tool->asked.measure = measure->axis;
  }
}

std::optional<Cause> HapticLoop::refusal_of(const LoopCommandBody& what) const noexcept {
  const LoopMachine& machine = kept_.machine;
  const bool fault = machine.state == LoopState::kFault;
  if (std::holds_alternative<EngageCommand>(what)) {
    if (fault) return machine.cause;
    if (machine.state == LoopState::kReady && contact_known() && !contact_free()) {
      return Cause::kOverlap;
    }
  }
  const bool moves_device =
      std::holds_alternative<PushCommand>(what) || std::holds_alternative<MeasureCommand>(what);
  if (moves_device && machine.state != LoopState::kEngaged) {
    return machine.cause == Cause::kNone ? Cause::kReleased : machine.cause;
  }
  if (std::holds_alternative<ClearCommand>(what) && fault) {
    const auto used = tools();
    const bool lost = std::any_of(used.begin(), used.end(),
                                  [](const ToolLoop& tool) { return tool.device_lost; });
    if (lost && machine.cause == Cause::kDeviceLost) return Cause::kDeviceLost;
    if (standing_fault_ != Cause::kNone && !latched_by_device(standing_fault_)) {
      return standing_fault_;
    }
  }
  return std::nullopt;
}

// A computed hand whose numbers have gone would be the cause for ever; so would what
// start_anew() is going to forget.
void HapticLoop::mend_devices() noexcept {
  if (kept_.machine.state != LoopState::kFault) return;
  bool any = numbers_lost() || far_off();
  for (PlayedTool& tool : scene().tools) {
    GestureHand* hand = tool.device.facets.hand;
    if (hand != nullptr) any = hand->recover() || any;
  }
  if (any && standing_fault_ == Cause::kNotFinite) standing_fault_ = Cause::kNone;
}

bool HapticLoop::numbers_lost() const noexcept {
  const auto used = tools();
  return std::any_of(used.begin(), used.end(),
                     [](const ToolLoop& tool) { return tool.wrench_not_finite; });
}

bool HapticLoop::far_off() const noexcept {
  const std::vector<PlayedTool>& played = scenes_.playing().tools;
  for (std::size_t k = 0; k < tool_count(); ++k) {
    if (lost_its_way(played[k], kept_.tools[k])) return true;
  }
  return false;
}

// What goes from tick to tick and would be the cause of the next fault: numbers of the simulation
// that are none, and a place that the clutch has brought a tool to from which no pose is in reach.
void HapticLoop::start_anew() noexcept {
  if (numbers_lost()) {
    scene().play.simulation->restart();
    for (ToolLoop& tool : tools()) tool.wrench_not_finite = false;
  }
  for (std::size_t k = 0; k < tool_count(); ++k) {
    if (lost_its_way(scene().tools[k], kept_.tools[k])) kept_.tools[k].workspace = {};
  }
}

void HapticLoop::lose_lease(const LeaseLostCommand& lost) noexcept {
  kept_.ramp.drop_later(kept_.time.tick, publisher_);
  orders_.lose_lease(lost.ended, forget_poses());
}

bool HapticLoop::forget_poses() noexcept {
  bool follows = false;
  for (PlayedTool& tool : scene().tools) {
    PoseQueue* poses = tool.device.facets.poses;
    if (poses == nullptr) continue;
    poses->clear();
    follows = true;
  }
  return follows;
}

void HapticLoop::play_gesture(std::unique_ptr<GesturePlan> plan, std::uint64_t number) noexcept {
  HD_ASSERT(plan != nullptr);
  if (!begin_gesture(*plan, scene())) {
    channels_.gestures.give_back(std::move(plan));
    publisher_.tell(CommandRefused{number, Cause::kNone});
    return;
  }
  channels_.gestures.give_back(std::exchange(scene().gesture, std::move(plan)));
  publisher_.tell(CommandDone{number});
}

void HapticLoop::take_change(std::unique_ptr<SettingsChange> change,
                             std::uint64_t number) noexcept {
  HD_ASSERT(change != nullptr);
  change->number = number;
  if (kept_.ramp.take(change, scene())) {
    publisher_.tell(CommandDone{number});
    return;
  }
  publisher_.retire(std::move(change), true);
  publisher_.tell(CommandRefused{number, Cause::kNone});
}

void HapticLoop::begin_scene() noexcept {
  HD_ASSERT(tool_count() >= 1 && tool_count() <= kMaxTools);
  kept_.time.tick = 0;
  kept_.time.period_ns = options_.period_ns;
  kept_.first_tick = true;
  snapshot_due_ns_ = kNow;
  tick_.budget.work = static_cast<std::uint64_t>(scene().work_budget);
  standing_fault_ = Cause::kNone;
  forget_rendered();
  for (std::size_t k = 0; k < tool_count(); ++k) {
    kept_.tools[k] = ToolLoop{};
    HapticDevice* device = scene().tools[k].device.device;
    HD_ASSERT(device != nullptr);
    ToolScene& tool = scene().play.simulation->scene(k);
    tool.stiffness_wanted = device->profile().affine;
    tool.clock = stage_clock();
    guard_.watch(k, device);
  }
  const GesturePlan* gesture = scene().gesture.get();
  if (gesture != nullptr) static_cast<void>(begin_gesture(*gesture, scene()));
}

void HapticLoop::swap_scene() noexcept {
  guard_.forget_devices();
  kept_.ramp.end(publisher_);
  scenes_.swap();
  const bool latched = kept_.machine.state == LoopState::kFault || kept_.machine.ending;
  if (options_.virtual_time && !latched) kept_.machine = LoopMachine{};
  begin_scene();
}

void HapticLoop::replace_scene(std::unique_ptr<PlayedScene> scene) noexcept {
  scenes_.wait(std::move(scene), 0);
  swap_scene();
  give_back_scene();
}

// The guardian may be writing to the old scene's device at this moment. Who asked for the scene
// hears of it before the answer.
void HapticLoop::give_back_scene() noexcept {
  if (!scenes_.has_retired() || guard_.busy()) return;
  channels_.scenes.give_back(scenes_.take_retired());
  publisher_.tell(SceneSwapped{scene().scene_id});
  if (const std::uint64_t number = scenes_.take_number(); number != 0) {
    publisher_.tell(CommandDone{number});
  }
}

void HapticLoop::take_scene(std::unique_ptr<PlayedScene> scene, std::uint64_t number) noexcept {
  scenes_.wait(std::move(scene), number);
  if (options_.virtual_time) {
    swap_scene();
    give_back_scene();
  }
}

void HapticLoop::tick_once(std::int64_t now_ns, std::uint64_t skipped) noexcept {
  guard_.beat(options_.virtual_time ? 0 : now_ns);
  take_commands();
  give_back_scene();
  gather_orders(now_ns);
  pass(now_ns, skipped);
}

// All that comes from outside beside samples, in one place: what is noted here is recorded, and
// given back by a replay. A device forgets only when it is told to, and says so a tick or two
// later; Clear waits for that.
void HapticLoop::gather_orders(std::int64_t now_ns) noexcept {
  const std::int64_t t_ns = kept_.time.t_ns;
  if (channels_.stop.take()) orders_.ask(StopCommand{}, t_ns);
  const std::uint64_t lost = channels_.events.overflow();
  unsigned orders = orders_.gather(t_ns, kept_.machine.state == LoopState::kFault);
  if (scenes_.waits()) orders |= kOrderSceneWaits;
  if (guard_.stalled()) orders |= kOrderStalled;
  if (channels_.stop.lets_go(now_ns)) orders |= kOrderDeadMan;
  if (std::exchange(events_overflow_, lost) != lost) orders |= kOrderEventLost;
  tick_.orders = static_cast<std::uint16_t>(orders);
  for (ToolLoop& tool : tools()) {
    constexpr unsigned kLatched = kDeviceReportsFault | kDeviceWatchdogFired;
    tool.clear_faults = orders_.clears(t_ns) && (tool.sample.flags & kLatched) != 0;
  }
}

void HapticLoop::replay_once(const Tick& recorded) noexcept {
  for (std::size_t k = 0; k < tool_count(); ++k) {
    const ToolTick& from = recorded.tools[k];
    ToolLoop& tool = kept_.tools[k];
    tool.asked = from.asked;
    SampleSource* source = scene().tools[k].device.facets.samples;
    if (source == nullptr) continue;
    ReplayedSample sample;
    sample.outcome = from.lost   ? ReadOutcome::kLost
                     : from.came ? ReadOutcome::kFresh
                                 : ReadOutcome::kNothing;
    sample.write_good = !from.write_failed;
    sample.sample = from.sample;
    source->put(sample);
  }
  tick_.orders = recorded.orders;
  tick_.budget.work = recorded.budget.work;
  give_back_scene();
  pass(recorded.t_ns, recorded.skipped);
}

bool HapticLoop::replay_change(std::unique_ptr<SettingsChange> change) noexcept {
  return kept_.ramp.take(change, scene());
}

void HapticLoop::begin_time(std::int64_t now_ns, std::uint64_t skipped) noexcept {
  LoopTime& time = kept_.time;
  time.tick += skipped;
  const std::int64_t before_ns = time.t_ns;
  time.t_ns =
      options_.virtual_time ? static_cast<std::int64_t>(time.tick) * options_.period_ns : now_ns;
  time.dt_ns = kept_.first_tick ? 0 : time.t_ns - before_ns;
  time.dt_s = 1e-9 * static_cast<double>(time.dt_ns);
  kept_.first_tick = false;
  tick_.skipped = skipped;
  tick_.times.overruns += skipped;
  late_ = watch_overrun(skipped > 0, time.t_ns, kept_.overruns);
  report_late(skipped);
}

// One line a second says as much as one per tick.
void HapticLoop::report_late(std::uint64_t skipped) noexcept {
  const LoopTime& time = kept_.time;
  late_skipped_ += skipped;
  if (late_skipped_ == 0 || time.t_ns - late_told_ns_ < kLateWindow_ns) return;
  channels_.log.push(make_log_record<LogCode::kTickLate>(
      time.t_ns, time.tick, static_cast<std::int64_t>(late_skipped_) * options_.period_ns,
      late_skipped_));
  late_skipped_ = 0;
  late_told_ns_ = time.t_ns;
}

void HapticLoop::pass(std::int64_t now_ns, std::uint64_t skipped) noexcept {
  StageClock* const clock = stage_clock();
  const std::uint32_t published_ns = clock_.times()[static_cast<std::size_t>(Stage::kPublish)];
  clock_.start(now_ns);
  begin_time(now_ns, skipped);
  tick_.change = kept_.ramp.follow(kept_.time, tools(), scene(), publisher_);
  tick_.settling = kept_.ramp.change() != nullptr;
  if ((tick_.orders & kOrderClear) != 0 && kept_.machine.state == LoopState::kFault) start_anew();
  read_devices();
  advance_state();
  lap(clock, Stage::kRead);
  render();
  limit_wrenches();
  lap(clock, Stage::kSafety);
  write_devices();
  lap(clock, Stage::kWrite);
  tick_.times.stages = clock_.times();
  tick_.times.stages[static_cast<std::size_t>(Stage::kPublish)] = published_ns;
  tell();
  ++kept_.time.tick;
  // The zero wrench of this tick was the last that the old scene's device gets.
  if (loop_output_.scene_allowed && scenes_.waits()) swap_scene();
  if (options_.virtual_time) return;
  clock_.lap(Stage::kPublish);
  const std::int64_t before_ns = std::exchange(cpu_before_ns_, thread_cpu_ns());
  const std::int64_t cpu_ns = before_ns == 0 ? 0 : cpu_before_ns_ - before_ns;
  tick_.times.cpu_ns = static_cast<std::uint32_t>(cpu_ns);
}

void HapticLoop::read_devices() noexcept {
  bool learned = false;
  for (std::size_t k = 0; k < tool_count(); ++k) {
    PlayedTool& played = scene().tools[k];
    read_tool(played, kept_.time, options_.guards_armed, kept_.tools[k]);
    learned = learn_delay(kept_.tools[k].sample, played) || learned;
  }
  if (learned) apply_settings(scene());
}

bool HapticLoop::all_have_poses() const noexcept {
  const auto used = tools();
  return std::all_of(used.begin(), used.end(),
                     [](const ToolLoop& tool) { return tool.guard.has_pose; });
}

bool HapticLoop::contact_free() const noexcept {
  const auto used = tools();
  return std::all_of(used.begin(), used.end(),
                     [](const ToolLoop& tool) { return tool.contact_free; });
}

bool HapticLoop::contact_known() const noexcept {
  const auto used = tools();
  return std::all_of(used.begin(), used.end(), [](const ToolLoop& tool) { return tool.rendered; });
}

// What a stall makes of the devices, such as a watchdog that fires, is not its cause.
HapticLoop::Fault HapticLoop::find_fault() const noexcept {
  const std::vector<PlayedTool>& played = scenes_.playing().tools;
  const bool any_pushes = std::any_of(played.begin(), played.end(), pushes_a_person);
  const auto latching = [&](bool wrong, Cause cause) {
    return wrong && latches(cause, any_pushes, options_.guards_armed);
  };
  if (latching((tick_.orders & kOrderStalled) != 0, Cause::kGuardian)) return {Cause::kGuardian, 0};
  for (std::size_t k = 0; k < tool_count(); ++k) {
    const Cause cause = fault_of(kept_.tools[k], pushes_a_person(played[k]), options_.guards_armed);
    if (cause != Cause::kNone) return {cause, k};
  }
  if (latching((tick_.orders & kOrderEventLost) != 0, Cause::kEventOverflow)) {
    return {Cause::kEventOverflow, 0};
  }
  if (latching(late_, Cause::kOverrun)) return {Cause::kOverrun, 0};
  return {};
}

void HapticLoop::advance_state() noexcept {
  LoopInput input;
  const auto has = [this](OrderBit order) { return (tick_.orders & order) != 0; };
  input.dt_s = kept_.time.dt_s;
  input.attached = true;
  input.calibrated = true;
  input.engages_itself = true;
  for (std::size_t k = 0; k < tool_count(); ++k) {
    const ToolLoop& tool = kept_.tools[k];
    if (tool.device_lost || (tool.sample.flags & kDeviceAttached) == 0) input.attached = false;
    if ((tool.sample.flags & kDeviceCalibrated) == 0) input.calibrated = false;
    if (pushes_a_person(scene().tools[k])) input.engages_itself = false;
    if ((tool.sample.flags & kDeviceDeadManOpen) != 0) input.block = Cause::kDeadMan;
    input.stale = input.stale || tool.judged.stale;
  }
  if (has(kOrderDeadMan)) input.block = Cause::kDeadMan;
  input.contact_free = contact_free();
  input.contact_known = contact_known();
  input.lease_lost = has(kOrderLeaseLost);
  input.scene_waits = has(kOrderSceneWaits);
  input.engage = has(kOrderEngage);
  input.disengage = has(kOrderDisengage);
  input.stop = has(kOrderStop);
  input.clear = has(kOrderClear);
  input.end = has(kOrderEnd);
  const Fault fault = find_fault();
  input.fault = standing_fault_ = fault.cause;
  const LoopState before = kept_.machine.state;
  const LoopTime& time = kept_.time;
  loop_output_ = advance(input, kept_.machine);
  tick_.state = loop_output_.state;
  tick_.cause = loop_output_.cause;
  if (tick_.state != before) {
    channels_.log.push(make_log_record<LogCode::kLoopStateChanged>(
        time.t_ns, static_cast<int>(before), static_cast<int>(tick_.state)));
  }
  for (ToolLoop& tool : tools()) {
    if (follow_push(tool.asked.push, tick_.state, time.dt_s, tool.push)) tool.safety.port = {};
    const SpringTick spring{tool.asked.measure, tick_.state, tool.asked.clutch_open, time.dt_s,
                            tool.judged.X_DH.p};
    follow_measuring(spring, tool.spring_under_test, tool.safety.port);
  }
  if (loop_output_.latched || loop_output_.cleared) {
    publisher_.tell(FaultNotice{tick_.cause, loop_output_.latched}, fault.tool);
  }
  // Where time stands still after it, what was queued would be first in it when it goes on, such as
  // the rest of the poses that made the fault.
  if (loop_output_.latched && options_.virtual_time) static_cast<void>(forget_poses());
  if (loop_output_.latched) {
    channels_.log.push(make_log_record<LogCode::kFaultLatched>(
        time.t_ns, static_cast<int>(tick_.cause), time.tick));
  }
}

// Of a pose that was forgotten nothing is told any more: the tools stand where they are, or, before
// their first pose, where they begin.
void HapticLoop::forget_rendered() noexcept {
  tick_.tools.clear();
  std::array<Pose, kMaxTools> X_WG_home;
  for (std::size_t k = 0; k < tool_count(); ++k) {
    X_WG_home[k] = scene().tools[k].X_WG_home;
    tick_.tools.push_back({});
  }
  tick_.strings.clear();
  tick_.string_forces.clear();
  scene().play.simulation->stand(X_WG_home, tick_);
  tick_.work = {};
  tick_.string_energy = 0.0;
  tick_.tank_energy = scene().play.simulation->strings().tank_energy();
}

// What cannot be used is not computed with: the last good pose again, at its own time, lets the
// simulation stand still.
void HapticLoop::render() noexcept {
  if (!all_have_poses()) {
    forget_rendered();
    for (ToolLoop& tool : tools()) {
      tool.F_H_D = Wrench{};
      tool.wanted = DeviceSpring{};
    }
    return;
  }
  for (std::size_t k = 0; k < tool_count(); ++k) {
    const Pose& X_WH = kept_.tools[k].placed.X_WH;
    tick_.tools[k].placed = {kept_.tools[k].judged.t_ns, to_array(X_WH.p), to_array(X_WH.q)};
  }
  Simulation& simulation = *scene().play.simulation;
  simulation.step(tick_);
  for (std::size_t k = 0; k < tool_count(); ++k) {
    take_rendered(scene().tools[k], simulation.rendered(k), kept_.tools[k]);
  }
}

void HapticLoop::limit_wrenches() noexcept {
  const StringPlayers& strings = scene().play.simulation->strings();
  bool enabled = false;
  for (std::size_t k = 0; k < tool_count(); ++k) {
    ToolLoop& tool = kept_.tools[k];
    limit_tool(scene().tools[k], kept_.time, loop_output_, strings.tank_energy(k), tool);
    enabled = enabled || tool.written.enable;
  }
  guard_.arm(enabled && !options_.virtual_time);
}

void HapticLoop::write_devices() noexcept {
  for (std::size_t k = 0; k < tool_count(); ++k) {
    write_tool(scene().tools[k], kept_.time, kept_.tools[k]);
  }
}

void HapticLoop::tell() noexcept {
  if (all_have_poses()) {
    publisher_.tell_strings(scene().play.simulation->events());
    if (options_.contacts_reported) publisher_.tell_touches(tools());
  }
  publisher_.publish(tools(), tick_);
  channels_.stop.tell(kept_.time.tick, tick_.state, tick_.cause);
  tick_.first = false;
  publish_snapshot();
  for (ToolLoop& tool : tools()) {
    tool.asked.push = tool.asked.measure = 0;
    if (tool.guard.has_pose) tool.asked.recentre = false;
  }
}

// After the tick, but before its number grows: the snapshot is of what the next tick starts from.
void HapticLoop::publish_snapshot() noexcept {
  if (!options_.snapshots || kept_.time.t_ns < snapshot_due_ns_) return;
  Snapshot* snapshot = channels_.snapshots.writable();
  if (snapshot == nullptr) return;
  snapshot_due_ns_ = kept_.time.t_ns + kSnapshotEvery_ns;
  if (!fill_snapshot(*snapshot)) return;
  ++snapshot->next_tick;
  channels_.snapshots.publish();
}

bool HapticLoop::fill_snapshot(Snapshot& snapshot) const noexcept {
  return hapticd::fill_snapshot(kept_, scenes_.playing(), snapshot);
}

bool HapticLoop::restore(const Snapshot& snapshot) {
  tick_.first = false;
  return hapticd::restore(snapshot, scene(), kept_);
}

}  // namespace hapticd
