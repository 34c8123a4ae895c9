// What the loop tells after a tick: events and the snapshot. See haptic_loop.h. RT: yes.
#include <algorithm>

#include "core/contact/tick_work.h"
#include "server/haptic_loop/haptic_loop.h"

namespace hapticd {
namespace {

ShownPhase phase_of(const StringReading& string) noexcept {
  if (!string.touched) return ShownPhase::kRinging;
  if (string.armed) return ShownPhase::kPressed;
  return string.level >= StringPhase::kFundamental ? ShownPhase::kDamped : ShownPhase::kTouched;
}

Wrench written_to_world(const PlayedTool& played, const ToolLoop& tool) noexcept {
  return to_world(played.map, Wrench{to_vector(tool.written.f_H_D), to_vector(tool.written.t_H_D)});
}

WrenchReading reading_of(const Wrench& F) noexcept { return {to_array(F.f), to_array(F.t)}; }

std::uint16_t flags_of(const ToolTick& tick, const ToolLoop& tool) noexcept {
  const std::uint32_t limited = tool.written.flags;
  std::uint32_t flags = 0;
  const auto set = [&](bool on, std::uint32_t bit) { flags |= on ? bit : 0U; };
  set((limited & kSafetySlew) != 0, kSlewLimited);
  set((limited & kSafetySaturated) != 0, kSaturated);
  set((limited & kSafetyThermal) != 0, kThermalLimited);
  set((limited & kSafetyPassivity) != 0, kPassivityLimited);
  set(tick.optimiser.status == ContactStatus::kRecovering, kRecovering);
  set(tick.optimiser.status == ContactStatus::kLagging, kLagging);
  set(tick.optimiser.rows_exchanged > 0, kRowsMerged);
  set(tick.optimiser.strings_refused > 0, kStringHeldRigid);
  set(tool.judged.held, kInputHeld);
  set(tool.placed.open, kClutched);
  set(!is_none(tool.spring), kDeviceSpring);
  return static_cast<std::uint16_t>(flags);
}

/// All tools together.
TickWork work_of(const TickOutput& output, std::int64_t budget) noexcept {
  TickWork work;
  work.work_budget = static_cast<std::uint64_t>(budget);
  for (const ToolTick& tool : output.tools) {
    work.sub_steps += static_cast<std::uint32_t>(tool.optimiser.sub_steps);
    work.qp_iterations += static_cast<std::uint32_t>(tool.optimiser.qp_iterations);
    work.sphere_tests += static_cast<std::uint64_t>(tool.optimiser.tests);
    work.work += static_cast<std::uint64_t>(tick_work(tool.optimiser));
    work.cut_short = work.cut_short || tool.optimiser.cut_short;
  }
  return work;
}

}  // namespace

template <typename What>
void HapticLoop::tell(const What& what, std::size_t tool) noexcept {
  channels_.events.push(
      {time_.tick, time_.t_ns, scene_->scene_id, scene_->tools[tool].tool_id, what});
}

template void HapticLoop::tell(const FaultNotice&, std::size_t) noexcept;
template void HapticLoop::tell(const SceneSwapped&, std::size_t) noexcept;
template void HapticLoop::tell(const SettingsRetired&, std::size_t) noexcept;
template void HapticLoop::tell(const CommandRefused&, std::size_t) noexcept;
template void HapticLoop::tell(const CommandDone&, std::size_t) noexcept;

void HapticLoop::report_events() noexcept {
  if (!all_have_poses()) return;
  for (const StringEvent& event : output_.events) {
    tell(event, static_cast<std::size_t>(std::max(event.tool, 0)));
  }
  if (!options_.contacts_reported) return;
  for (std::size_t k = 0; k < tool_count(); ++k) {
    const ToolTick& tick = output_.tools[k];
    const ToolScene& scene = scene_->play.simulation->scene(k);
    touch_events_.clear();
    detect_touches(tools_[k].contacts,
                   {time_.t_ns, time_.dt_ns, tick.X_WG.p, tick.V_WH, scene.stiffness.kt,
                    static_cast<std::int32_t>(scene.strings.size())},
                   tools_[k].touches, touch_events_);
    for (const TouchEvent& event : touch_events_) tell(event, k);
  }
}

void HapticLoop::fill_tool(std::size_t k, ToolReading& reading) const noexcept {
  const ToolTick& tick = output_.tools[k];
  const ToolLoop& tool = tools_[k];
  const PlayedTool& played = scene_->tools[k];
  reading = ToolReading{};
  reading.tool_id = played.tool_id;
  reading.flags = flags_of(tick, tool);
  reading.p_WH = to_array(tick.X_WH.p);
  reading.q_WH = to_array(tick.X_WH.q);
  reading.p_WG = to_array(tick.X_WG.p);
  reading.q_WG = to_array(tick.X_WG.q);
  reading.F_H_W = reading_of(written_to_world(played, tool));
  reading.F_computed_H_W = reading_of(tick.F_computed_H_W);
  reading.minimum_gap = tick.optimiser.minimum_gap;
  const DeviceSample& sample = tool.sample;
  reading.device = {sample.p_DH,    sample.q_DH, sample.grip_m, sample.temperature_deg_c,
                    sample.buttons, sample.flags};
  reading.input_age_ns = time_.t_ns - sample.t_ns;
  reading.port_energy = tool.safety.port.given;
  reading.removed_energy = tool.safety.port.removed;
  reading.stiffness_scale = played.grant.scale;
  reading.stiffness_bound = played.grant.bound;
  reading.delay = played.stiffness_limits.delay_s;
  reading.measured_delay = sample.measured_delay_s;
  fill_gesture(k, reading);
}

void HapticLoop::fill_gesture(std::size_t k, ToolReading& reading) const noexcept {
  const GestureHand* hand = scene_->tools[k].device.facets.hand;
  if (hand == nullptr || scene_->gesture == nullptr) return;
  const GestureProgress progress = hand->gesture();
  reading.plays_gesture = progress.playing;
  reading.gesture_progress = progress.fraction;
  reading.gesture_repeats = progress.finished;
  reading.gesture_name = scene_->gesture->name;
}

// Where they are too many each tool gets the same share, and what the ones with few leave.
void HapticLoop::fill_contacts(Snapshot& snapshot) const noexcept {
  snapshot.contacts.total = 0;
  auto& listed = snapshot.contacts.contacts;
  listed.clear();
  std::array<std::size_t, kMaxTools> order{};
  for (std::size_t k = 0; k < tool_count(); ++k) {
    std::size_t at = k;
    for (; at > 0 &&
           tools_[order[at - 1]].contacts.contacts.size() > tools_[k].contacts.contacts.size();
         --at) {
      order[at] = order[at - 1];
    }
    order[at] = k;
  }
  std::size_t left = kMaxReportedContacts;
  for (std::size_t i = 0; i < tool_count(); ++i) {
    const std::size_t size = tools_[order[i]].contacts.contacts.size();
    const std::size_t count = std::min(size, left / (tool_count() - i));
    snapshot.tools[order[i]].contacts = static_cast<std::int32_t>(count);
    left -= count;
  }
  for (std::size_t k = 0; k < tool_count(); ++k) {
    const ContactReport& report = tools_[k].contacts;
    snapshot.contacts.total += report.total;
    const auto count = static_cast<std::size_t>(snapshot.tools[k].contacts);
    for (std::size_t i = 0; i < count; ++i) listed.push_back(report.contacts[i]);
  }
}

void HapticLoop::fill_strings(Snapshot& snapshot) const noexcept {
  snapshot.strings.clear();
  snapshot.string_forces.clear();
  snapshot.string_energy = 0.0;
  const auto tracks = scene_->play.simulation->tracks();
  for (const StringReading& string : output_.strings) {
    snapshot.strings.push_back({string.string, phase_of(string), string.lambda,
                                string.radius_growth, to_array(string.deflection_W)});
    snapshot.string_energy +=
        tracks[static_cast<std::size_t>(string.string)].state.vibration.energy;
  }
  for (std::size_t k = 0; k < tool_count(); ++k) {
    for (const PressedString& contact : output_.tools[k].strings) {
      snapshot.string_forces.push_back(
          {static_cast<std::int32_t>(k), contact.string, to_array(contact.F_W)});
    }
  }
}

void HapticLoop::publish_snapshot() noexcept {
  Snapshot* snapshot = channels_.snapshots.writable();
  if (snapshot == nullptr) return;
  snapshot->tick = time_.tick;
  snapshot->t_ns = time_.t_ns;
  snapshot->scene_id = scene_->scene_id;
  snapshot->loop_state = machine_.state;
  snapshot->cause = machine_.cause;
  snapshot->timing = timing_;
  snapshot->work = work_of(output_, work_budget_);
  snapshot->quality_level = scene_->quality_level;
  snapshot->quality_automatic = scene_->settings.tools.front().quality_automatic;
  snapshot->tank_energy = scene_->play.simulation->tank_energy();
  snapshot->tools.clear();
  for (std::size_t k = 0; k < tool_count(); ++k) {
    if (ToolReading* tool = snapshot->tools.append()) fill_tool(k, *tool);
  }
  fill_contacts(*snapshot);
  fill_strings(*snapshot);
  channels_.snapshots.publish();
}

void HapticLoop::fill_trace(std::size_t k, ToolTrace& trace) const noexcept {
  const ToolTick& tick = output_.tools[k];
  const ToolLoop& tool = tools_[k];
  const PlayedTool& played = scene_->tools[k];
  trace.tool_id = played.tool_id;
  trace.buttons = tool.sample.buttons;
  trace.has_velocity = tool.sample.has_velocity;
  trace.lost = tool.device_lost;
  trace.write_failed = tool.write_failed;
  trace.recentre = tool.recentre_asked;
  trace.clutch_open = tool.clutch_open;
  trace.push = tool.push_asked;
  trace.device_flags = tool.sample.flags;
  trace.sample_t_ns = tool.sample.t_ns;
  trace.sample_counter = tool.sample.counter;
  trace.v_DH_D = tool.sample.v_DH_D;
  trace.w_DH_D = tool.sample.w_DH_D;
  trace.flags = flags_of(tick, tool);
  trace.sample_came = tool.sample_came;
  trace.held = tool.judged.held;
  trace.age_ns =
      static_cast<std::uint64_t>(std::max<std::int64_t>(time_.t_ns - tool.sample.t_ns, 0));
  trace.stiffness_scale = played.grant.scale;
  trace.measured_delay_s = tool.sample.measured_delay_s;
  trace.p_DH = tool.sample.p_DH;
  trace.q_DH = tool.sample.q_DH;
  trace.p_WH = to_array(tick.X_WH.p);
  trace.q_WH = to_array(tick.X_WH.q);
  trace.v_WH_W = to_array(tick.V_WH.v);
  trace.w_WH_W = to_array(tick.V_WH.w);
  trace.p_WG = to_array(tick.X_WG.p);
  trace.q_WG = to_array(tick.X_WG.q);
  trace.f_computed_H_W = to_array(tick.F_computed_H_W.f);
  trace.t_computed_H_W = to_array(tick.F_computed_H_W.t);
  const Wrench F_H_W = written_to_world(played, tool);
  trace.f_H_W = to_array(F_H_W.f);
  trace.t_H_W = to_array(F_H_W.t);
}

void HapticLoop::publish_trace() noexcept {
  TickTrace* trace = channels_.traces.writable();
  if (trace == nullptr) return;
  const TickWork work = work_of(output_, work_budget_);
  trace->tick = time_.tick;
  trace->t_ns = static_cast<std::uint64_t>(time_.t_ns);
  trace->dt_ns = static_cast<std::uint64_t>(time_.dt_ns);
  trace->state_hash = 0;
  trace->skipped = skipped_;
  trace->change = begun_change_;
  trace->orders = orders_;
  trace->first = !ever_ticked_;
  trace->sphere_tests = work.sphere_tests;
  trace->qp_iterations = work.qp_iterations;
  trace->work_budget = work.work_budget;
  trace->substeps = work.sub_steps;
  trace->level = scene_->quality_level;
  trace->scene_id = scene_->scene_id;
  trace->cpu_ns = timing_.cpu_ns;
  trace->loop_state = machine_.state;
  trace->cause = machine_.cause;
  trace->tool_count = static_cast<std::int32_t>(tool_count());
  for (std::size_t k = 0; k < tool_count(); ++k) fill_trace(k, trace->tools[k]);
  channels_.traces.publish();
}

}  // namespace hapticd
