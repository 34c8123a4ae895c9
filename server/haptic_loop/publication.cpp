// What the loop tells after a tick: its events and its record. See haptic_loop.h. RT: yes.
#include <algorithm>

#include "core/contact/tick_work.h"
#include "server/haptic_loop/haptic_loop.h"

namespace hapticd {
namespace {

Wrench written_to_world(const PlayedTool& played, const ToolLoop& tool) noexcept {
  return to_world(played.map, Wrench{to_vector(tool.written.f_H_D), to_vector(tool.written.t_H_D)});
}

std::uint16_t flags_of(const RenderedTool& tick, const ToolLoop& tool) noexcept {
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
WorkTick work_of(const TickOutput& output) noexcept {
  WorkTick work;
  for (const RenderedTool& tool : output.tools) {
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
    const RenderedTool& tick = output_.tools[k];
    const ToolScene& scene = scene_->play.simulation->scene(k);
    scene_->play.simulation->report_contacts(k, tools_[k].contacts);
    touch_events_.clear();
    detect_touches(tools_[k].contacts,
                   {time_.t_ns, time_.dt_ns, tick.X_WG.p, tick.V_WH, scene.stiffness.kt,
                    static_cast<std::int32_t>(scene.strings.size())},
                   tools_[k].touches, touch_events_);
    for (const TouchEvent& event : touch_events_) tell(event, k);
  }
}

void HapticLoop::fill_tool(std::size_t k, ToolTick& told) const noexcept {
  const RenderedTool& rendered = output_.tools[k];
  const ToolLoop& tool = tools_[k];
  const PlayedTool& played = scene_->tools[k];
  told.tool_id = played.tool_id;
  told.flags = flags_of(rendered, tool);
  told.asked = {tool.recentre_asked, tool.clutch_open, tool.push_asked};
  told.sample = tool.sample;
  told.came = tool.sample_came;
  told.lost = tool.device_lost;
  told.write_failed = tool.write_failed;
  told.held = tool.judged.held;
  told.X_WH = to_plain(rendered.X_WH);
  told.V_WH = to_plain(rendered.V_WH);
  told.X_WG = to_plain(rendered.X_WG);
  told.minimum_gap = rendered.optimiser.minimum_gap;
  told.F_computed_H_W = to_plain(rendered.F_computed_H_W);
  told.F_written_H_W = to_plain(written_to_world(played, tool));
  told.port = {tool.safety.port.given, tool.safety.port.removed};
  told.stiffness = {played.grant.scale, played.grant.bound, played.stiffness_limits.delay_s};
  told.gesture.plays = false;
  const GestureHand* hand = played.device.facets.hand;
  if (hand == nullptr || scene_->gesture == nullptr) return;
  const GestureProgress progress = hand->gesture();
  told.gesture = {progress.playing, progress.fraction, progress.finished, scene_->gesture->name};
}

// Where they are too many each tool gets the same share, and what the ones with few leave.
void HapticLoop::fill_contacts() noexcept {
  tick_.contacts_total = 0;
  tick_.contacts.clear();
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
    tick_.tools[order[i]].contacts = static_cast<std::int32_t>(count);
    left -= count;
  }
  for (std::size_t k = 0; k < tool_count(); ++k) {
    const ContactReport& report = tools_[k].contacts;
    tick_.contacts_total += report.total;
    const auto count = static_cast<std::size_t>(tick_.tools[k].contacts);
    for (std::size_t i = 0; i < count; ++i) tick_.contacts.push_back(report.contacts[i]);
  }
}

void HapticLoop::fill_strings() noexcept {
  tick_.strings.clear();
  tick_.string_forces.clear();
  tick_.string_energy = 0.0;
  for (const StringTick& string : output_.strings) {
    tick_.strings.push_back(string);
    tick_.string_energy += string.energy;
  }
  for (std::size_t k = 0; k < tool_count(); ++k) {
    for (const PressedString& contact : output_.tools[k].strings) {
      tick_.string_forces.push_back(
          {static_cast<std::int32_t>(k), contact.string, to_array(contact.F_W)});
    }
  }
}

void HapticLoop::fill_head() noexcept {
  tick_.tick = time_.tick;
  tick_.t_ns = time_.t_ns;
  tick_.dt_ns = time_.dt_ns;
  tick_.skipped = skipped_;
  tick_.change = begun_change_;
  tick_.scene_id = scene_->scene_id;
  tick_.orders = orders_;
  tick_.first = !ever_ticked_;
  tick_.state = machine_.state;
  tick_.cause = machine_.cause;
  tick_.budget = {scene_->quality_level, scene_->settings.tools.front().quality_automatic,
                  static_cast<std::uint64_t>(work_budget_)};
  tick_.work = work_of(output_);
  tick_.times = times_;
  tick_.tank_energy = scene_->play.simulation->tank_energy();
}

void HapticLoop::publish_tick() noexcept {
  fill_head();
  tick_.tools.clear();
  for (std::size_t k = 0; k < tool_count(); ++k) {
    if (ToolTick* told = tick_.tools.append()) fill_tool(k, *told);
  }
  fill_contacts();
  fill_strings();
  channels_.ticks.push(tick_);
  channels_.recorded.push(tick_);
}

}  // namespace hapticd
