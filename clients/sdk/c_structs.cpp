// See c_structs.h.
#include "clients/sdk/c_structs.h"

namespace hapticd::client {
namespace {

template <typename Number, typename Numbers, std::size_t Count>
void copy(const Numbers& from, Number (&to)[Count]) {
  for (std::size_t k = 0; k < Count && static_cast<int>(k) < from.size(); ++k) {
    to[k] = from[static_cast<int>(k)];
  }
}

void fill(const v1::ToolState& tool, hapticd_tool& made) {
  made.tool_id = static_cast<std::int32_t>(tool.tool_id());
  for (const int flag : tool.flags()) {
    if (flag >= 1 && flag <= 32) made.flags |= std::uint32_t{1} << (flag - 1);
  }
  copy(tool.p_wh_m(), made.p_wh_m);
  copy(tool.p_wg_m(), made.p_wg_m);
  copy(tool.q_wh(), made.q_wh);
  copy(tool.q_wg(), made.q_wg);
  copy(tool.wrench_h_w(), made.wrench_h_w);
  made.minimum_gap_m = tool.minimum_gap_m();
}

void fill(const v1::StringState& string, hapticd_string& made) {
  made.string_index = static_cast<std::int32_t>(string.string_index());
  made.phase = static_cast<std::uint32_t>(string.phase());
  copy(string.deflection_w_m(), made.deflection_w_m);
  made.lambda = string.lambda();
  made.radius_m = string.radius_m();
}

void fill(const v1::Tone& tone, hapticd_event& made) {
  made.kind = HAPTICD_EVENT_TONE;
  made.t_ns = tone.t_ns();
  made.tool_id = static_cast<std::int32_t>(tone.tool_id());
  made.string_index = static_cast<std::int32_t>(tone.string_index());
  made.frequency_hz = tone.frequency_hz();
  made.amplitude_m = tone.amplitude_m();
  made.level = tone.level();
  made.lambda = tone.lambda();
  made.decay_s = tone.decay_s();
  made.normal_speed_m_per_s = tone.normal_speed_m_per_s();
  made.tangential_speed_m_per_s = tone.tangential_speed_m_per_s();
}

void fill(const v1::Contact& contact, hapticd_event& made) {
  made.kind = HAPTICD_EVENT_CONTACT;
  made.t_ns = contact.t_ns();
  made.phase = contact.phase();
  made.tool_id = static_cast<std::int32_t>(contact.tool_id());
  made.part_index = contact.part_index();
  if (contact.has_string_index()) made.string_index = static_cast<int>(contact.string_index());
  if (contact.has_body_index()) made.body_index = static_cast<int>(contact.body_index());
  if (contact.has_line_index()) made.line_index = static_cast<int>(contact.line_index());
  made.lambda = contact.lambda();
  copy(contact.p_wc_m(), made.p_wc_m);
  copy(contact.nhat_og_w(), made.nhat_og_w);
  made.normal_speed_m_per_s = contact.normal_speed_m_per_s();
  made.tangential_speed_m_per_s = contact.tangential_speed_m_per_s();
  made.force_n = contact.force_n();
}

void fill(const v1::StringRadius& radius, hapticd_event& made) {
  made.kind = HAPTICD_EVENT_STRING_RADIUS;
  made.t_ns = radius.t_ns();
  made.phase = radius.phase();
  made.string_index = static_cast<std::int32_t>(radius.string_index());
  made.delta_m = radius.delta_m();
  made.amplitude_m = radius.r_max_m();
  made.decay_s = radius.decay_s();
  made.frequency_hz = radius.frequency_hz();
}

void fill(const v1::Fault& fault, hapticd_event& made) {
  made.kind = HAPTICD_EVENT_FAULT;
  made.t_ns = fault.t_ns();
  made.cause = fault.cause();
  made.latched = fault.latched() ? 1 : 0;
  if (fault.has_tool_id()) made.tool_id = static_cast<std::int32_t>(fault.tool_id());
  fault.message().copy(made.message, whole_characters(fault.message(), sizeof made.message - 1));
}

}  // namespace

std::size_t whole_characters(std::string_view text, std::size_t most) {
  if (text.size() <= most) return text.size();
  // Bytes in the middle of a character begin with the bits 10.
  while (most > 0 && (static_cast<unsigned char>(text[most]) & 0xC0U) == 0x80U) --most;
  return most;
}

hapticd_state c_state(const v1::State& state) {
  hapticd_state made{};
  made.size = sizeof made;
  made.scene_id = state.scene_id();
  made.tick = state.tick();
  made.t_ns = state.t_ns();
  made.loop_state = state.loop_state();
  made.cause = state.cause();
  const auto strings = static_cast<std::uint32_t>(state.strings_size());
  made.tool_count = static_cast<std::uint32_t>(state.tools_size());
  made.string_count = std::max(strings, state.strings_total());
  for (hapticd_tool& tool : made.tools) tool.tool_id = -1;
  for (hapticd_string& string : made.strings) string.string_index = -1;
  for (int k = 0; k < std::min(state.tools_size(), int{HAPTICD_MOST_TOOLS}); ++k) {
    fill(state.tools(k), made.tools[k]);
  }
  for (int k = 0; k < std::min(state.strings_size(), int{HAPTICD_MOST_STRINGS}); ++k) {
    fill(state.strings(k), made.strings[k]);
  }
  return made;
}

bool is_c_event(const v1::Item& item) {
  return item.has_tone() || item.has_contact() || item.has_string_radius() || item.has_fault() ||
         item.has_scene_info() || item.has_lease_info();
}

hapticd_event c_event(const v1::Item& item) {
  hapticd_event made{};
  made.size = sizeof made;
  made.tool_id = -1;
  made.string_index = -1;
  made.body_index = -1;
  made.line_index = -1;
  if (item.has_tone()) fill(item.tone(), made);
  if (item.has_contact()) fill(item.contact(), made);
  if (item.has_string_radius()) fill(item.string_radius(), made);
  if (item.has_fault()) fill(item.fault(), made);
  if (item.has_scene_info()) made.kind = HAPTICD_EVENT_SCENE;
  if (item.has_lease_info()) made.kind = HAPTICD_EVENT_LEASE;
  return made;
}

}  // namespace hapticd::client
