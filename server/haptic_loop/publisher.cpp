// See publisher.h. RT: yes.
#include "server/haptic_loop/publisher.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/simulation/contact_report.h"

namespace hapticd {
namespace {

std::uint16_t flags_of(const ContactOutcome& contact, const ToolLoop& tool) noexcept {
  const std::uint32_t limited = tool.written.flags;
  std::uint32_t flags = 0;
  const auto set = [&](bool on, std::uint32_t bit) { flags |= on ? bit : 0U; };
  set((limited & kSafetySlew) != 0, kSlewLimited);
  set((limited & kSafetySaturated) != 0, kSaturated);
  set((limited & kSafetyThermal) != 0, kThermalLimited);
  set((limited & kSafetyPassivity) != 0, kPassivityLimited);
  set(contact.status == ContactStatus::kRecovering, kRecovering);
  set(contact.status == ContactStatus::kLagging, kLagging);
  set(contact.rows_exchanged > 0, kRowsMerged);
  set(contact.strings_refused > 0, kStringHeldRigid);
  set(tool.judged.held, kInputHeld);
  set(tool.placed.open, kClutched);
  set(!is_none(tool.spring), kDeviceSpring);
  return static_cast<std::uint16_t>(flags);
}

void fill_tool(const PlayedTool& played, const ToolLoop& tool, ToolTick& told) noexcept {
  told.tool_id = played.tool_id;
  told.flags = flags_of(told.contact, tool);
  told.asked = tool.asked;
  told.sample = tool.sample;
  told.came = tool.sample_came;
  told.lost = tool.device_lost;
  told.write_failed = tool.write_failed;
  told.held = tool.judged.held;
  told.F_written_H_W = to_plain(
      to_world(played.map, Wrench{to_vector(tool.written.f_H_D), to_vector(tool.written.t_H_D)}));
  told.f_written_H_D = tool.written.f_H_D;
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

void Publisher::tell_touches(std::span<ToolLoop> tools) noexcept {
  Simulation& simulation = *scenes_.playing().play.simulation;
  for (std::size_t k = 0; k < tools.size(); ++k) {
    const RenderedTool& tick = simulation.rendered(k);
    const ToolScene& scene = simulation.scene(k);
    report_contacts(simulation.memory(), simulation.strings().sharing(), k, tools[k].contacts);
    touch_events_.clear();
    detect_touches(tools[k].contacts,
                   {time_.t_ns, time_.dt_ns, tick.X_WG.p, tick.V_WH, scene.stiffness,
                    static_cast<std::int32_t>(scene.strings.size())},
                   tools[k].touches, touch_events_);
    for (const TouchEvent& event : touch_events_) tell(event, k);
  }
}

void Publisher::publish(std::span<const ToolLoop> tools, Tick& tick) noexcept {
  const PlayedScene& scene = scenes_.playing();
  tick.tick = time_.tick;
  tick.t_ns = time_.t_ns;
  tick.dt_ns = time_.dt_ns;
  tick.scene_id = scene.scene_id;
  tick.budget.level = scene.quality_level;
  tick.budget.automatic = scene.settings.tools.front().quality_automatic;
  for (std::size_t k = 0; k < tools.size(); ++k) {
    fill_tool(scene.tools[k], tools[k], tick.tools[k]);
    fill_gesture(scene, scene.tools[k], tick.tools[k].gesture);
  }
  fill_contacts(tools, tick);
  channels_.ticks.push(tick);
  channels_.recorded.push(tick);
}

}  // namespace hapticd
