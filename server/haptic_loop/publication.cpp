// What the loop tells after a tick: events and the snapshot. See haptic_loop.h. RT: yes.
#include <algorithm>

#include "server/haptic_loop/haptic_loop.h"

namespace hapticd {
namespace {

StringPhase phase_of(const StringReading& string) noexcept {
  if (!string.touched) return StringPhase::kRinging;
  if (string.armed) return StringPhase::kPressed;
  return string.level >= StringLevel::kFundamental ? StringPhase::kDamped : StringPhase::kTouched;
}

WrenchReading reading_of(const Wrench& F) noexcept { return {to_array(F.f), to_array(F.t)}; }

std::uint16_t flags_of(const ToolTick& tick, const SafetyOutput& written, bool held,
                       bool clutched) noexcept {
  std::uint32_t flags = 0;
  const auto set = [&](bool on, std::uint32_t bit) { flags |= on ? bit : 0U; };
  set((written.flags & kSafetySlew) != 0, kSlewLimited);
  set((written.flags & kSafetySaturated) != 0, kSaturated);
  set((written.flags & kSafetyThermal) != 0, kThermalLimited);
  set((written.flags & kSafetyPassivity) != 0, kPassivityLimited);
  set(tick.optimiser.status == OptimiserStatus::kRecovering, kRecovering);
  set(tick.optimiser.status == OptimiserStatus::kLagging, kLagging);
  set(tick.optimiser.rows_exchanged > 0, kRowsMerged);
  set(tick.optimiser.strings_refused > 0, kStringHeldRigid);
  set(held, kInputHeld);
  set(clutched, kClutched);
  return static_cast<std::uint16_t>(flags);
}

}  // namespace

template <typename What>
void HapticLoop::tell(const What& what) noexcept {
  channels_.events.push({tick_, t_ns_, scene_->scene_id, scene_->tool_id, what});
}

template void HapticLoop::tell(const FaultNotice&) noexcept;
template void HapticLoop::tell(const SceneSwapped&) noexcept;
template void HapticLoop::tell(const GestureRetired&) noexcept;
template void HapticLoop::tell(const SettingsRetired&) noexcept;
template void HapticLoop::tell(const CommandRefused&) noexcept;
template void HapticLoop::tell(const CommandDone&) noexcept;

void HapticLoop::report_events() noexcept {
  if (!input_watch_.has_pose) return;
  for (const StringEvent& event : output_.events) tell(event);
  if (!options_.contacts_reported) return;
  const ToolTick& tool = output_.tools[0];
  touch_events_.clear();
  const ToolScene& scene = scene_->play.simulation->scene(0);
  detect_touches(contacts_,
                 {t_ns_, dt_ns_, tool.X_WG.p, tool.V_WH, scene.stiffness.kt,
                  static_cast<std::int32_t>(scene.strings.size())},
                 touches_, touch_events_);
  for (const TouchEvent& event : touch_events_) tell(event);
}

void HapticLoop::fill_tool(ToolReading& tool) const noexcept {
  const ToolTick& tick = output_.tools[0];
  tool = ToolReading{};
  tool.tool_id = scene_->tool_id;
  tool.flags = flags_of(tick, written_, watched_.held, placed_.open);
  tool.p_WH = to_array(tick.X_WH.p);
  tool.q_WH = to_array(tick.X_WH.q);
  tool.p_WG = to_array(tick.X_WG.p);
  tool.q_WG = to_array(tick.X_WG.q);
  const Wrench written{to_vector(written_.f_H_D), to_vector(written_.t_H_D)};
  tool.F_H_W = reading_of(to_world(scene_->map, written));
  tool.F_unlimited_H_W = reading_of(tick.F_unlimited_H_W);
  tool.minimum_gap = tick.optimiser.minimum_gap;
  tool.device = {sample_.p_DH,    sample_.q_DH, sample_.grip_m, sample_.temperature_deg_c,
                 sample_.buttons, sample_.flags};
  tool.input_age_ns = t_ns_ - sample_.t_ns;
  tool.port_energy = safety_.port.given;
  tool.removed_energy = safety_.port.removed;
  tool.stiffness_scale = scene_->grant.scale;
  tool.stiffness_bound = scene_->grant.bound;
  tool.delay = scene_->stiffness_limits.delay_s;
  if (scene_->device.simulated == nullptr || scene_->gesture == nullptr) return;
  const GestureProgress progress = scene_->device.simulated->gesture();
  tool.plays_gesture = progress.playing;
  tool.gesture_progress = progress.fraction;
  tool.gesture_repeats = progress.finished;
  tool.gesture_name = scene_->gesture->name;
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
  for (const StringContact& contact : output_.tools[0].strings) {
    snapshot.string_forces.push_back({contact.string, to_array(contact.F_W)});
  }
}

void HapticLoop::publish_snapshot() noexcept {
  Snapshot* snapshot = channels_.snapshots.writable();
  if (snapshot == nullptr) return;
  snapshot->tick = tick_;
  snapshot->t_ns = t_ns_;
  snapshot->scene_id = scene_->scene_id;
  snapshot->loop_state = machine_.state;
  snapshot->cause = machine_.cause;
  snapshot->timing = timing_;
  const OptimiserResult& optimiser = output_.tools[0].optimiser;
  snapshot->work = {static_cast<std::uint32_t>(optimiser.sub_steps),
                    static_cast<std::uint32_t>(optimiser.qp_iterations),
                    static_cast<std::uint64_t>(optimiser.tests)};
  snapshot->quality_level = scene_->quality_level;
  snapshot->quality_automatic = scene_->settings.live.quality_automatic;
  snapshot->tank_energy = scene_->play.simulation->tank_energy();
  snapshot->tools.clear();
  if (ToolReading* tool = snapshot->tools.append()) fill_tool(*tool);
  snapshot->contacts.total = contacts_.total;
  snapshot->contacts.contacts.clear();
  for (const ContactReading& contact : contacts_.contacts) {
    snapshot->contacts.contacts.push_back(contact);
  }
  fill_strings(*snapshot);
  channels_.snapshots.publish();
}

void HapticLoop::publish_trace() noexcept {
  TickTrace* trace = channels_.traces.writable();
  if (trace == nullptr) return;
  const ToolTick& tick = output_.tools[0];
  trace->tick = tick_;
  trace->t_ns = static_cast<std::uint64_t>(t_ns_);
  trace->dt_ns = static_cast<std::uint64_t>(dt_ns_);
  trace->state_hash = 0;
  trace->sphere_tests = static_cast<std::uint64_t>(tick.optimiser.tests);
  trace->qp_iterations = static_cast<std::uint64_t>(tick.optimiser.qp_iterations);
  trace->substeps = static_cast<std::uint32_t>(tick.optimiser.sub_steps);
  trace->level = scene_->quality_level;
  trace->scene_id = scene_->scene_id;
  trace->cpu_ns = timing_.cpu_ns;
  trace->loop_state = machine_.state;
  trace->cause = machine_.cause;
  trace->tool_count = 1;
  ToolTrace& tool = trace->tools[0];
  tool.tool_id = scene_->tool_id;
  tool.buttons = sample_.buttons;
  tool.flags = flags_of(tick, written_, watched_.held, placed_.open);
  tool.sample_came = sample_came_;
  tool.held = watched_.held;
  tool.age_ns = static_cast<std::uint64_t>(std::max<std::int64_t>(t_ns_ - sample_.t_ns, 0));
  tool.stiffness_scale = scene_->grant.scale;
  tool.p_DH = sample_.p_DH;
  tool.q_DH = sample_.q_DH;
  tool.p_WH = to_array(tick.X_WH.p);
  tool.q_WH = to_array(tick.X_WH.q);
  tool.v_WH_W = to_array(tick.V_WH.v);
  tool.w_WH_W = to_array(tick.V_WH.w);
  tool.p_WG = to_array(tick.X_WG.p);
  tool.q_WG = to_array(tick.X_WG.q);
  tool.f_unlimited_H_W = to_array(tick.F_unlimited_H_W.f);
  tool.t_unlimited_H_W = to_array(tick.F_unlimited_H_W.t);
  const Wrench F_H_W =
      to_world(scene_->map, Wrench{to_vector(written_.f_H_D), to_vector(written_.t_H_D)});
  tool.f_H_W = to_array(F_H_W.f);
  tool.t_H_W = to_array(F_H_W.t);
  channels_.traces.publish();
}

}  // namespace hapticd
