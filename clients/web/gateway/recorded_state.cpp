// See recorded_state.h.
#include "clients/web/gateway/recorded_state.h"

#include <cmath>

namespace hapticd::web {
namespace {

const v1::ToolOutput* output_of(const v1::TickRecord& tick, std::uint32_t tool_id) {
  for (const v1::ToolOutput& each : tick.outputs()) {
    if (each.tool_id() == tool_id) return &each;
  }
  return nullptr;
}

void put_wrench(const v1::Wrench& from, google::protobuf::RepeatedField<float>& to) {
  for (const double f : from.f_n()) to.Add(static_cast<float>(f));
  for (const double t : from.t_n_m()) to.Add(static_cast<float>(t));
}

void put_pose(const v1::Pose& from, google::protobuf::RepeatedField<double>& p,
              google::protobuf::RepeatedField<float>& q) {
  p = from.p_m();
  for (const double each : from.q()) q.Add(static_cast<float>(each));
}

void add_tool(const v1::ToolInput& input, const v1::TickRecord& tick, v1::State& state) {
  v1::ToolState& tool = *state.add_tools();
  tool.set_tool_id(input.tool_id());
  put_pose(input.pose_wh(), *tool.mutable_p_wh_m(), *tool.mutable_q_wh());
  const v1::ToolOutput* output = output_of(tick, input.tool_id());
  if (output == nullptr) return;
  put_pose(output->pose_wg(), *tool.mutable_p_wg_m(), *tool.mutable_q_wg());
  put_wrench(output->wrench_h_w(), *tool.mutable_wrench_h_w());
  put_wrench(output->wrench_unlimited_h_w(), *tool.mutable_wrench_unlimited_h_w());
  *tool.mutable_flags() = output->flags();
}

void add_device(const v1::ToolInput& input, v1::State& state) {
  if (!input.has_pose_dh()) return;
  v1::DeviceState& device = *state.add_devices();
  device.set_tool_id(input.tool_id());
  put_pose(input.pose_dh(), *device.mutable_p_dh_m(), *device.mutable_q_dh());
  device.set_buttons(input.buttons());
  for (int bit = 0; bit < 16; ++bit) {
    const int flag = bit + 1;
    if ((input.device_flags() >> static_cast<unsigned>(bit) & 1U) != 0 &&
        v1::DeviceFlag_IsValid(flag)) {
      device.add_flags(static_cast<v1::DeviceFlag>(flag));
    }
  }
}

std::uint32_t object_index(const v1::Contact& contact) {
  switch (contact.object_case()) {
    case v1::Contact::kStringIndex:
      return contact.string_index();
    case v1::Contact::kBodyIndex:
      return contact.body_index();
    default:
      return contact.line_index();
  }
}

}  // namespace

void RecordedState::take_scene(const v1::SceneRecord& record) {
  scene_ = record.scene();
  clear();
}

void RecordedState::clear() {
  strings_.clear();
  touched_.clear();
}

void RecordedState::take_event(const v1::Item& item, const v1::TickRecord* tick) {
  if (item.has_contact()) take_contact(item.contact(), tick);
  if (item.has_tone()) strings_[item.tone().string_index()].lambda = item.tone().lambda();
  if (item.has_string_radius()) {
    strings_[item.string_radius().string_index()].radius = item.string_radius();
  }
}

void RecordedState::take_contact(const v1::Contact& contact, const v1::TickRecord* tick) {
  const Touch touch{contact.tool_id(), contact.part_index(),
                    static_cast<int>(contact.object_case()), object_index(contact)};
  if (contact.phase() == v1::CONTACT_PHASE_END) {
    touched_.erase(touch);
    return;
  }
  Touched& touched = touched_[touch];
  touched = {contact, {}, false};
  if (contact.has_string_index()) strings_[contact.string_index()].lambda = contact.lambda();
  const v1::ToolOutput* tool = tick != nullptr ? output_of(*tick, contact.tool_id()) : nullptr;
  if (tool == nullptr || tool->pose_wg().p_m_size() != 3) return;
  for (int i = 0; i < 3; ++i) {
    touched.p_WG[static_cast<std::size_t>(i)] = tool->pose_wg().p_m(i);
  }
  touched.placed = true;
}

v1::State RecordedState::state_of(const v1::TickRecord& tick) const {
  v1::State state;
  state.set_tick(tick.tick());
  state.set_t_ns(tick.t_ns());
  state.set_loop_state(tick.loop_state());
  state.set_cause(tick.cause());
  state.set_scene_id(tick.scene_id());
  for (const v1::ToolInput& input : tick.inputs()) {
    add_tool(input, tick, state);
    add_device(input, state);
  }
  state.mutable_timing()->set_last_ns(tick.cpu_ns());
  state.mutable_quality()->set_level(tick.budget().level());
  state.mutable_quality()->set_work_budget(tick.budget().work());
  add_strings(tick, state);
  add_contacts(tick, state);
  return state;
}

void RecordedState::add_strings(const v1::TickRecord& tick, v1::State& state) const {
  for (const auto& [index, course] : strings_) {
    const v1::StringRadius& radius = course.radius;
    const auto place = static_cast<int>(index);
    if (place >= scene_.strings_size()) continue;
    const double age_s =
        (static_cast<double>(tick.t_ns()) - static_cast<double>(radius.t_ns())) * 1e-9;
    auto beyond_m = static_cast<double>(radius.delta_m());
    v1::StringPhase phase = v1::STRING_PHASE_PRESSED;
    if (radius.phase() != v1::STRING_RADIUS_PHASE_PRESS) {
      const auto decay_s = static_cast<double>(radius.decay_s());
      const bool damped = radius.phase() == v1::STRING_RADIUS_PHASE_DAMP;
      phase = damped ? v1::STRING_PHASE_DAMPED : v1::STRING_PHASE_RINGING;
      const bool rings = decay_s > 0.0 && age_s >= 0.0;
      beyond_m = rings ? static_cast<double>(radius.r_max_m()) * std::exp(-age_s / decay_s) : 0.0;
      if (beyond_m < kStillEnvelope_m) continue;
    }
    if (radius.phase() == v1::STRING_RADIUS_PHASE_UNSPECIFIED) continue;
    v1::StringState& string = *state.add_strings();
    string.set_string_index(index);
    string.set_phase(phase);
    string.set_lambda(course.lambda);
    string.set_radius_m(static_cast<float>(scene_.strings(place).radius_m() + beyond_m));
  }
}

void RecordedState::add_contacts(const v1::TickRecord& tick, v1::State& state) const {
  for (const auto& [touch, touched] : touched_) {
    const v1::Contact& contact = touched.contact;
    const v1::ToolOutput* tool = output_of(tick, contact.tool_id());
    if (contact.p_wc_m_size() != 3 || contact.nhat_og_w_size() != 3) continue;
    v1::ContactPatch& patch = *state.add_contacts();
    patch.set_tool_id(contact.tool_id());
    if (contact.has_string_index()) patch.set_string_index(contact.string_index());
    if (contact.has_body_index()) patch.set_body_index(contact.body_index());
    if (contact.has_line_index()) patch.set_line_index(contact.line_index());
    const bool moves = touched.placed && tool != nullptr && tool->pose_wg().p_m_size() == 3;
    for (int i = 0; i < 3; ++i) {
      const auto axis = static_cast<std::size_t>(i);
      const double moved_m = moves ? tool->pose_wg().p_m(i) - touched.p_WG[axis] : 0.0;
      patch.add_p_wc_um(std::llround((static_cast<double>(contact.p_wc_m(i)) + moved_m) * 1e6));
      patch.add_nhat_og_w_e4(static_cast<std::int32_t>(std::lround(contact.nhat_og_w(i) * 1e4F)));
      patch.add_force_w_n(contact.nhat_og_w(i) * contact.force_n());
    }
    patch.add_tool_sphere(0);
    patch.add_gap_nanometres(0);
    patch.add_force_mn(static_cast<std::uint32_t>(std::lround(contact.force_n() * 1e3F)));
  }
}

v1::SceneInfo scene_info_of(const v1::SceneRecord& record, const v1::RecordHeader& header) {
  v1::SceneInfo info;
  info.set_scene_id(record.scene_id());
  *info.mutable_scene() = record.scene();
  *info.mutable_quality_in_force() = record.scene().quality();
  *info.mutable_solver_in_force() = record.scene().solver();
  info.set_hash(record.hash());
  *info.mutable_assets() = record.assets();
  if (header.period_ns() > 0) info.set_rate_hz(1e9 / static_cast<double>(header.period_ns()));
  info.set_clock(header.config().clock());
  info.set_server_version(header.server_version());
  return info;
}

}  // namespace hapticd::web
