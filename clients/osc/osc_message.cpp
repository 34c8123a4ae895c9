// See osc_message.h.
#include "clients/osc/osc_message.h"

namespace hapticd::osc {
namespace {

std::int32_t whole(std::uint32_t number) { return static_cast<std::int32_t>(number); }

OscMessage tone(const v1::Tone& event) {
  return {"/haptic/tone",
          {whole(event.string_index()), whole(event.tool_id()), event.frequency_hz(), event.level(),
           event.amplitude_m(), event.lambda(), event.decay_s(), event.glide_cents(),
           event.glide_decay_s()},
          event.t_ns()};
}

OscMessage contact(const v1::Contact& event) {
  std::string kind = "line";
  std::uint32_t index = event.line_index();
  if (event.has_string_index()) {
    kind = "string";
    index = event.string_index();
  } else if (event.has_body_index()) {
    kind = "body";
    index = event.body_index();
  }
  const bool begins = event.phase() == v1::CONTACT_PHASE_BEGIN;
  OscMessage message{"/haptic/contact",
                     {begins ? 1 : 0, whole(event.tool_id()), kind, whole(index), event.lambda()},
                     event.t_ns()};
  for (int i = 0; i < 3; ++i) {
    message.arguments.emplace_back(i < event.p_wc_m_size() ? event.p_wc_m(i) : 0.0F);
  }
  message.arguments.emplace_back(event.force_n());
  message.arguments.emplace_back(event.normal_speed_m_per_s());
  message.arguments.emplace_back(event.tangential_speed_m_per_s());
  return message;
}

OscMessage string_radius(const v1::StringRadius& event) {
  std::string phase = "press";
  if (event.phase() == v1::STRING_RADIUS_PHASE_RELEASE) phase = "release";
  if (event.phase() == v1::STRING_RADIUS_PHASE_DAMP) phase = "damp";
  return {"/haptic/string",
          {whole(event.string_index()), phase, event.delta_m(), event.r_max_m(), event.decay_s(),
           event.frequency_hz()},
          event.t_ns()};
}

/// Index, pitch, glide, ends of the part, then amplitude and decay of each partial.
OscMessage string_sounding(const v1::StringSounding& event) {
  OscMessage message{"/haptic/sounding",
                     {whole(event.string_index()), event.frequency_hz(), event.cents_per_s(),
                      event.lambda_from(), event.lambda_to()},
                     event.t_ns()};
  for (int i = 0; i < event.partials_m_size() && i < event.decays_s_size(); ++i) {
    message.arguments.emplace_back(event.partials_m(i));
    message.arguments.emplace_back(event.decays_s(i));
  }
  return message;
}

}  // namespace

std::optional<OscMessage> message_of(const v1::Item& item) {
  if (item.has_tone()) return tone(item.tone());
  if (item.has_contact()) return contact(item.contact());
  if (item.has_string_radius()) return string_radius(item.string_radius());
  if (item.has_string_sounding()) return string_sounding(item.string_sounding());
  if (item.has_scene_info()) {
    const v1::Scene& scene = item.scene_info().scene();
    OscMessage message{"/haptic/scene", {scene.name(), std::int32_t{scene.strings_size()}}, 0};
    for (const v1::String& string : scene.strings()) {
      message.arguments.emplace_back(static_cast<float>(string.frequency_hz()));
    }
    return message;
  }
  return std::nullopt;
}

std::vector<OscMessage> poses_of(const v1::State& state) {
  std::vector<OscMessage> messages;
  for (const v1::ToolState& tool : state.tools()) {
    if (tool.p_wg_m_size() != 3 || tool.q_wg_size() != 4 || tool.wrench_h_w_size() != 6) continue;
    OscMessage message{"/haptic/pose", {whole(tool.tool_id())}, state.t_ns()};
    for (const double p : tool.p_wg_m()) message.arguments.emplace_back(static_cast<float>(p));
    for (const float q : tool.q_wg()) message.arguments.emplace_back(q);
    for (int i = 0; i < 3; ++i) message.arguments.emplace_back(tool.wrench_h_w(i));
    messages.push_back(std::move(message));
  }
  return messages;
}

}  // namespace hapticd::osc
