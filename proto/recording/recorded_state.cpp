// See recorded_state.h.
#include "proto/recording/recorded_state.h"

#include <algorithm>

namespace hapticd {
namespace {

using Floats = google::protobuf::RepeatedField<float>;

void put_floats(const google::protobuf::RepeatedField<double>& from, Floats& to) {
  for (const double each : from) to.Add(static_cast<float>(each));
}

void put_wrench(const v1::Wrench& from, Floats& to) {
  put_floats(from.f_n(), to);
  put_floats(from.t_n_m(), to);
}

bool equal(const v1::Wrench& a, const v1::Wrench& b) {
  return std::equal(a.f_n().begin(), a.f_n().end(), b.f_n().begin(), b.f_n().end()) &&
         std::equal(a.t_n_m().begin(), a.t_n_m().end(), b.t_n_m().begin(), b.t_n_m().end());
}

void put_tool(const v1::ToolInput& input, const v1::ToolOutput& output, v1::ToolState& tool) {
  tool.set_tool_id(input.tool_id());
  *tool.mutable_p_wh_m() = input.pose_wh().p_m();
  put_floats(input.pose_wh().q(), *tool.mutable_q_wh());
  *tool.mutable_p_wg_m() = output.pose_wg().p_m();
  put_floats(output.pose_wg().q(), *tool.mutable_q_wg());
  put_wrench(output.wrench_h_w(), *tool.mutable_wrench_h_w());
  if (!equal(output.wrench_h_w(), output.wrench_unlimited_h_w())) {
    put_wrench(output.wrench_unlimited_h_w(), *tool.mutable_wrench_unlimited_h_w());
  }
  *tool.mutable_flags() = output.flags();
}

void put_device(const v1::ToolInput& input, v1::DeviceState& device) {
  device.set_tool_id(input.tool_id());
  *device.mutable_p_dh_m() = input.pose_dh().p_m();
  put_floats(input.pose_dh().q(), *device.mutable_q_dh());
  device.set_buttons(input.buttons());
  for (unsigned bit = 0; bit < 16; ++bit) {
    if ((input.device_flags() >> bit & 1U) == 0) continue;
    device.add_flags(static_cast<v1::DeviceFlag>(bit + 1));
  }
}

}  // namespace

v1::State state_of(const v1::TickRecord& tick) {
  v1::State state = tick.shown();
  state.set_tick(tick.tick());
  state.set_t_ns(tick.t_ns());
  state.set_loop_state(tick.loop_state());
  state.set_cause(tick.cause());
  state.set_scene_id(tick.scene_id());
  if (tick.cpu_ns() > 0) state.mutable_timing()->set_last_ns(tick.cpu_ns());
  const int tools = std::min(tick.inputs_size(), tick.outputs_size());
  while (state.tools_size() > tools) state.mutable_tools()->RemoveLast();
  for (int k = 0; k < tools; ++k) {
    v1::ToolState& tool = k < state.tools_size() ? *state.mutable_tools(k) : *state.add_tools();
    put_tool(tick.inputs(k), tick.outputs(k), tool);
    if (tick.inputs(k).has_pose_dh()) put_device(tick.inputs(k), *state.add_devices());
  }
  return state;
}

}  // namespace hapticd
