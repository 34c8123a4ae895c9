// See encode_event.h.
#include "server/encoding/encode_event.h"

#include <algorithm>
#include <array>

namespace hapticd {
namespace {

std::uint64_t wire_time(std::int64_t t_ns) {
  return static_cast<std::uint64_t>(std::max<std::int64_t>(t_ns, 0));
}

const PieceOwner& piece_of(const SceneIndex& index, std::int32_t capsule) {
  return index.pieces[static_cast<std::size_t>(capsule)];
}

void encode_tone(const EventPlace& place, const StringEvent& string, const SceneIndex& index,
                 v1::Tone& tone) {
  const PieceOwner& piece = piece_of(index, string.string);
  tone.set_t_ns(wire_time(string.t_ns));
  tone.set_string_index(piece.index);
  tone.set_tool_id(place.tool_id);
  tone.set_frequency_hz(static_cast<float>(string.frequency));
  tone.set_amplitude_m(static_cast<float>(string.amplitude));
  tone.set_level(static_cast<float>(string.level));
  tone.set_lambda(static_cast<float>(whole_lambda(piece, string.lambda)));
  tone.set_decay_s(static_cast<float>(string.decay));
  tone.set_normal_speed_m_per_s(static_cast<float>(string.normal_speed));
  tone.set_tangential_speed_m_per_s(static_cast<float>(string.tangential_speed));
  tone.set_glide_cents(static_cast<float>(string.glide_cents));
  tone.set_glide_decay_s(static_cast<float>(string.glide_decay));
  for (int k = 0; k < string.partial_count; ++k) {
    tone.add_partials(string.partials[static_cast<std::size_t>(k)]);
  }
}

void encode_radius(const StringEvent& string, const SceneIndex& index, v1::StringRadius& radius) {
  radius.set_t_ns(wire_time(string.t_ns));
  radius.set_string_index(piece_of(index, string.string).index);
  switch (string.radius_phase) {
    case RadiusPhase::kPress:
      radius.set_phase(v1::STRING_RADIUS_PHASE_PRESS);
      break;
    case RadiusPhase::kRelease:
      radius.set_phase(v1::STRING_RADIUS_PHASE_RELEASE);
      break;
    case RadiusPhase::kDamp:
      radius.set_phase(v1::STRING_RADIUS_PHASE_DAMP);
      break;
  }
  radius.set_delta_m(static_cast<float>(string.deflection));
  radius.set_r_max_m(static_cast<float>(string.amplitude));
  radius.set_decay_s(static_cast<float>(string.decay));
  radius.set_frequency_hz(static_cast<float>(string.frequency));
}

void encode_sounding(const EventPlace& place, const StringEvent& string, const SceneIndex& index,
                     v1::StringSounding& sounding) {
  const PieceOwner& piece = piece_of(index, string.string);
  sounding.set_t_ns(wire_time(string.t_ns));
  sounding.set_string_index(piece.index);
  sounding.set_tool_id(place.tool_id);
  sounding.set_number(string.number);
  sounding.set_cause(static_cast<v1::SoundingCause>(static_cast<int>(string.cause) + 1));
  sounding.set_lambda_from(static_cast<float>(whole_lambda(piece, string.lambda)));
  sounding.set_lambda_to(static_cast<float>(whole_lambda(piece, string.lambda_to)));
  sounding.set_frequency_hz(static_cast<float>(string.frequency));
  sounding.set_cents_per_s(static_cast<float>(string.cents_per_s));
  sounding.set_inharmonicity(static_cast<float>(string.inharmonicity));
  for (int k = 0; k < string.partial_count; ++k) {
    const auto n = static_cast<std::size_t>(k);
    sounding.add_partials_m(string.partials[n]);
    sounding.add_decays_s(string.decays[n]);
    if (string.cause == SoundingCause::kOnset) sounding.add_phases_rad(string.phases[n]);
  }
}

void add_place(const Array3& p_WC, const Array3& nhat_OG_W, v1::Contact& contact) {
  for (const double p : p_WC) contact.add_p_wc_m(static_cast<float>(p));
  for (const double n : nhat_OG_W) contact.add_nhat_og_w(static_cast<float>(n));
}

void encode_string_contact(const EventPlace& place, const StringEvent& string,
                           const SceneIndex& index, v1::Contact& contact) {
  const PieceOwner& piece = piece_of(index, string.string);
  contact.set_t_ns(wire_time(string.t_ns));
  contact.set_phase(string.kind == StringEventKind::kTouch ? v1::CONTACT_PHASE_BEGIN
                                                           : v1::CONTACT_PHASE_END);
  contact.set_tool_id(place.tool_id);
  contact.set_part_index(static_cast<std::uint32_t>(std::max(string.part, 0)));
  contact.set_string_index(piece.index);
  contact.set_lambda(static_cast<float>(whole_lambda(piece, string.lambda)));
  add_place(string.p_WC, string.nhat_OG_W, contact);
  contact.set_normal_speed_m_per_s(static_cast<float>(string.normal_speed));
  contact.set_tangential_speed_m_per_s(static_cast<float>(string.tangential_speed));
  contact.set_force_n(static_cast<float>(string.force));
  contact.set_ringing(string.ringing);
}

bool encode_string(const EventPlace& place, const StringEvent& string, const SceneIndex& index,
                   v1::Item& item) {
  switch (string.kind) {
    case StringEventKind::kTone:
      encode_tone(place, string, index, *item.mutable_tone());
      break;
    case StringEventKind::kRadius:
      encode_radius(string, index, *item.mutable_string_radius());
      break;
    case StringEventKind::kSounding:
      encode_sounding(place, string, index, *item.mutable_string_sounding());
      break;
    case StringEventKind::kTouch:
    case StringEventKind::kLeave:
    case StringEventKind::kRelease:
      encode_string_contact(place, string, index, *item.mutable_contact());
      break;
    case StringEventKind::kPress:
      return false;
  }
  return true;
}

void encode_touch(const EventPlace& place, const TouchEvent& touch, const SceneIndex& index,
                  v1::Contact& contact) {
  contact.set_t_ns(wire_time(touch.t_ns));
  contact.set_phase(touch.begins ? v1::CONTACT_PHASE_BEGIN : v1::CONTACT_PHASE_END);
  contact.set_tool_id(place.tool_id);
  contact.set_part_index(static_cast<std::uint32_t>(touch.part));
  if (is_body({touch.kind, touch.obstacle})) {
    contact.set_body_index(static_cast<std::uint32_t>(touch.obstacle));
  } else {
    const PieceOwner& piece = piece_of(index, touch.obstacle);
    contact.set_line_index(piece.index);
    contact.set_lambda(static_cast<float>(whole_lambda(piece, touch.lambda)));
  }
  add_place(touch.p_WC, touch.nhat_OG_W, contact);
  contact.set_normal_speed_m_per_s(static_cast<float>(touch.normal_speed));
  contact.set_tangential_speed_m_per_s(static_cast<float>(touch.tangential_speed));
  contact.set_force_n(static_cast<float>(touch.force));
}

}  // namespace

std::optional<v1::Item> encode_event(const StringEvent& event, const EventPlace& place,
                                     const SceneIndex& index) {
  v1::Item item;
  if (!encode_string(place, event, index, item)) return std::nullopt;
  return item;
}

v1::Item encode_event(const TouchEvent& event, const EventPlace& place, const SceneIndex& index) {
  v1::Item item;
  encode_touch(place, event, index, *item.mutable_contact());
  return item;
}

v1::Item encode_fault(Cause cause, bool latched, const EventPlace& place) {
  v1::Item item;
  v1::Fault& fault = *item.mutable_fault();
  fault.set_t_ns(wire_time(place.t_ns));
  fault.set_tick(place.tick);
  fault.set_cause(static_cast<v1::Cause>(cause));
  fault.set_tool_id(place.tool_id);
  fault.set_latched(latched);
  fault.set_message(std::string(explain(cause)));
  return item;
}

std::string_view explain(Cause cause) noexcept {
  static constexpr std::array<std::string_view, kMaxCause + 1> kTexts{
      "",
      "A client asked for Stop. Clear to go on.",
      "A pose, velocity or wrench was not a finite number, or a quaternion could not be "
      "normalised. "
      "Check what gives the poses, then Clear.",
      "No new sample came from the device for more than two ticks. Check cable and driver, then "
      "Clear.",
      "The device repeats one pose while its counter advances: a sensor is stuck. Check it, then "
      "Clear.",
      "The handle moved faster than the profile allows. Hold it, then Clear.",
      "More than 20 ticks in one second were late. hapticd doctor says why; then Clear.",
      "The loop stood still and the guardian wrote zero. hapticd doctor says why; then Clear.",
      "The lease of the controller that gave the poses ran out. Acquire it again, then Clear.",
      "The device is gone. Plug it in.",
      "The device reports a fault. See its manual, then Clear.",
      "Forces do not reach the device. Check the cable, then Clear.",
      "The device's own watchdog has fired. Clear to go on.",
      "The emergency stop is pressed. Release it, then Clear.",
      "The dead-man switch is open. Hold it.",
      "The device's zero is not known. Calibrate it.",
      "The device has not passed its guided first check, so it is not engaged.",
      "The tool touches or overlaps the scene. Move it away: force comes on by itself, or on "
      "Engage.",
      "Events were lost because their ring was full. The network thread is too slow: hapticd "
      "doctor.",
      "The replay differs from its recording.",
      "A fault was injected, as asked for with --inject.",
      "Released.",
  };
  return kTexts[static_cast<std::size_t>(cause)];
}

}  // namespace hapticd
