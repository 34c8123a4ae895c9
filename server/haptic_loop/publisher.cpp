// See publisher.h. RT: yes.
#include "server/haptic_loop/publisher.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/contact/tick_work.h"
#include "core/simulation/contact_report.h"

namespace hapticd {
namespace {

std::uint16_t flags_of(const RenderedTool& tick, const ToolLoop& tool) noexcept {
  const std::uint32_t limited = tool.written.flags;
  std::uint32_t flags = 0;
  const auto set = [&](bool on, std::uint32_t bit) { flags |= on ? bit : 0U; };
  set((limited & kSafetySlew) != 0, kSlewLimited);
  set((limited & kSafetySaturated) != 0, kSaturated);
  set((limited & kSafetyThermal) != 0, kThermalLimited);
  set((limited & kSafetyPassivity) != 0, kPassivityLimited);
  set(tick.contact.status == ContactStatus::kRecovering, kRecovering);
  set(tick.contact.status == ContactStatus::kLagging, kLagging);
  set(tick.contact.rows_exchanged > 0, kRowsMerged);
  set(tick.contact.strings_refused > 0, kStringHeldRigid);
  set(tool.judged.held, kInputHeld);
  set(tool.placed.open, kClutched);
  set(!is_none(tool.spring), kDeviceSpring);
  return static_cast<std::uint16_t>(flags);
}

/// All tools together.
WorkTick work_of(const TickOutput& output) noexcept {
  WorkTick work;
  for (const RenderedTool& tool : output.tools) {
    work.sub_steps += static_cast<std::uint32_t>(tool.contact.sub_steps);
    work.qp_iterations += static_cast<std::uint32_t>(tool.contact.qp_iterations);
    work.sphere_tests += static_cast<std::uint64_t>(tool.contact.tests);
    work.work += static_cast<std::uint64_t>(tick_work(tool.contact));
    work.cut_short = work.cut_short || tool.contact.cut_short;
  }
  return work;
}

void fill_tool(const RenderedTool& rendered, const PlayedTool& played, const ToolLoop& tool,
               ToolTick& told) noexcept {
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
  told.minimum_gap = rendered.contact.minimum_gap;
  told.F_computed_H_W = to_plain(rendered.F_computed_H_W);
  told.F_written_H_W = to_plain(
      to_world(played.map, Wrench{to_vector(tool.written.f_H_D), to_vector(tool.written.t_H_D)}));
  told.port = {tool.safety.port.given, tool.safety.port.removed};
  told.stiffness = {played.grant.scale, played.grant.bound, played.stiffness_limits.delay_s};
}

void fill_gesture(const PlayedScene& scene, const PlayedTool& played, GestureTick& told) noexcept {
  told.plays = false;
  const GestureHand* hand = played.device.facets.hand;
  if (hand == nullptr || scene.gesture == nullptr) return;
  const GestureProgress progress = hand->gesture();
  told = {progress.playing, static_cast<double>(progress.fraction), progress.finished,
          scene.gesture->name};
}

// Where they are too many each tool gets the same share, and what the ones with few leave.
void fill_contacts(std::span<const ToolLoop> tools, Tick& tick) noexcept {
  tick.contacts_total = 0;
  tick.contacts.clear();
  std::array<std::size_t, kMaxTools> order{};
  for (std::size_t k = 0; k < tools.size(); ++k) {
    std::size_t at = k;
    for (; at > 0 &&
           tools[order[at - 1]].contacts.contacts.size() > tools[k].contacts.contacts.size();
         --at) {
      order[at] = order[at - 1];
    }
    order[at] = k;
  }
  std::size_t left = kMaxReportedContacts;
  for (std::size_t i = 0; i < tools.size(); ++i) {
    const std::size_t size = tools[order[i]].contacts.contacts.size();
    const std::size_t count = std::min(size, left / (tools.size() - i));
    tick.tools[order[i]].contacts = static_cast<std::int32_t>(count);
    left -= count;
  }
  for (std::size_t k = 0; k < tools.size(); ++k) {
    const ContactReport& report = tools[k].contacts;
    tick.contacts_total += report.total;
    const auto count = static_cast<std::size_t>(tick.tools[k].contacts);
    for (std::size_t i = 0; i < count; ++i) tick.contacts.push_back(report.contacts[i]);
  }
}

void fill_strings(const TickOutput& output, Tick& tick) noexcept {
  tick.strings.clear();
  tick.string_forces.clear();
  tick.string_energy = 0.0;
  for (const StringTick& string : output.strings) {
    tick.strings.push_back(string);
    tick.string_energy += string.energy;
  }
  for (std::size_t k = 0; k < output.tools.size(); ++k) {
    for (const PressedString& contact : output.tools[k].strings) {
      tick.string_forces.push_back(
          {static_cast<std::int32_t>(k), contact.string, to_array(contact.F_W)});
    }
  }
}

}  // namespace

void Publisher::retire(std::unique_ptr<SettingsChange> change, bool dropped) noexcept {
  if (change == nullptr) return;
  tell(SettingsRetired{change->number, dropped});
  channels_.changes.give_back(std::move(change));
}

void Publisher::tell_strings(const StringEvents& events) noexcept {
  for (const StringEvent& event : events) {
    tell(event, static_cast<std::size_t>(std::max(event.tool, 0)));
  }
}

void Publisher::tell_touches(const TickOutput& output, std::span<ToolLoop> tools) noexcept {
  Simulation& simulation = *scenes_.playing().play.simulation;
  for (std::size_t k = 0; k < tools.size(); ++k) {
    const RenderedTool& tick = output.tools[k];
    const ToolScene& scene = simulation.scene(k);
    report_contacts(simulation.memory().tools[k], tools[k].contacts);
    touch_events_.clear();
    detect_touches(tools[k].contacts,
                   {time_.t_ns, time_.dt_ns, tick.X_WG.p, tick.V_WH, scene.stiffness.kt,
                    static_cast<std::int32_t>(scene.strings.size())},
                   tools[k].touches, touch_events_);
    for (const TouchEvent& event : touch_events_) tell(event, k);
  }
}

void Publisher::publish(const TickOutput& output, std::span<const ToolLoop> tools,
                        Tick& tick) noexcept {
  const PlayedScene& scene = scenes_.playing();
  tick.tick = time_.tick;
  tick.t_ns = time_.t_ns;
  tick.dt_ns = time_.dt_ns;
  tick.scene_id = scene.scene_id;
  tick.budget.level = scene.quality_level;
  tick.budget.automatic = scene.settings.tools.front().quality_automatic;
  tick.work = work_of(output);
  tick.tank_energy = scene.play.simulation->strings().tank_energy();
  tick.tools.clear();
  for (std::size_t k = 0; k < tools.size(); ++k) {
    ToolTick* told = tick.tools.append();
    if (told == nullptr) break;
    fill_tool(output.tools[k], scene.tools[k], tools[k], *told);
    fill_gesture(scene, scene.tools[k], told->gesture);
  }
  fill_contacts(tools, tick);
  fill_strings(output, tick);
  channels_.ticks.push(tick);
  channels_.recorded.push(tick);
}

}  // namespace hapticd
