// See tick_record.h.
#include "server/recorder/tick_record.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/math/state_fields.h"

namespace hapticd {
namespace {

using Numbers = google::protobuf::RepeatedField<double>;

template <std::size_t N>
void set(const std::array<double, N>& from, Numbers& to) {
  to.Clear();
  to.Add(from.begin(), from.end());
}

template <std::size_t N>
bool get(const Numbers& from, std::array<double, N>& to) {
  if (from.size() != static_cast<int>(N)) return false;
  for (std::size_t k = 0; k < N; ++k) to[k] = from[static_cast<int>(k)];
  return true;
}

void set_pose(const Array3& p, const Array4& q, v1::Pose& pose) {
  set(p, *pose.mutable_p_m());
  set(q, *pose.mutable_q());
}

bool get_pose(const v1::Pose& pose, Array3& p, Array4& q) {
  return get(pose.p_m(), p) && get(pose.q(), q);
}

void set_wrench(const Array3& f, const Array3& t, v1::Wrench& wrench) {
  set(f, *wrench.mutable_f_n());
  set(t, *wrench.mutable_t_n_m());
}

bool get_wrench(const v1::Wrench& wrench, Array3& f, Array3& t) {
  return get(wrench.f_n(), f) && get(wrench.t_n_m(), t);
}

void set_input(const ToolTrace& tool, v1::ToolInput& input) {
  input.set_tool_id(tool.tool_id);
  if (tool.sample_came) set_pose(tool.p_DH, tool.q_DH, *input.mutable_pose_dh());
  set_pose(tool.p_WH, tool.q_WH, *input.mutable_pose_wh());
  set(tool.v_WH_W, *input.mutable_twist_wh_w()->mutable_v_m_per_s());
  set(tool.w_WH_W, *input.mutable_twist_wh_w()->mutable_w_rad_per_s());
  input.set_buttons(tool.buttons);
  input.add_stiffness_scale(tool.stiffness_scale);
  input.set_age_ns(tool.age_ns);
  input.set_held(tool.held);
  input.set_sample_t_ns(tool.sample_t_ns);
  input.set_sample_counter(tool.sample_counter);
  if (tool.has_velocity) {
    set(tool.v_DH_D, *input.mutable_twist_dh_d()->mutable_v_m_per_s());
    set(tool.w_DH_D, *input.mutable_twist_dh_d()->mutable_w_rad_per_s());
  }
  input.set_device_flags(tool.device_flags);
  input.set_lost(tool.lost);
  input.set_write_failed(tool.write_failed);
  input.set_recentre(tool.recentre);
  input.set_clutch_open(tool.clutch_open);
  input.set_push(static_cast<v1::Axis>(tool.push));
  if (!std::isnan(tool.measured_delay_s)) input.set_measured_delay_s(tool.measured_delay_s);
}

/// Whether the loop can reckon with it: see kMax_ns.
bool is_instant(std::int64_t t_ns) { return t_ns > -kMax_ns && t_ns < kMax_ns; }
bool is_instant(std::uint64_t t_ns) { return t_ns < std::uint64_t{kMax_ns}; }

bool get_input(const v1::ToolInput& input, ToolTrace& tool) {
  tool.tool_id = input.tool_id();
  tool.sample_came = input.has_pose_dh();
  if (tool.sample_came && !get_pose(input.pose_dh(), tool.p_DH, tool.q_DH)) return false;
  tool.has_velocity = input.has_twist_dh_d();
  if (tool.has_velocity && (!get(input.twist_dh_d().v_m_per_s(), tool.v_DH_D) ||
                            !get(input.twist_dh_d().w_rad_per_s(), tool.w_DH_D))) {
    return false;
  }
  std::array<double, 1> scale{};
  if (!get_pose(input.pose_wh(), tool.p_WH, tool.q_WH) ||
      !get(input.twist_wh_w().v_m_per_s(), tool.v_WH_W) ||
      !get(input.twist_wh_w().w_rad_per_s(), tool.w_WH_W) || !get(input.stiffness_scale(), scale) ||
      input.buttons() > 0xFFFFU || input.device_flags() > 0xFFFFU || !is_instant(input.age_ns()) ||
      !is_instant(input.sample_t_ns()) || input.push() < 0 || input.push() > kPushAxes) {
    return false;
  }
  tool.stiffness_scale = scale[0];
  tool.buttons = static_cast<std::uint16_t>(input.buttons());
  tool.age_ns = input.age_ns();
  tool.held = input.held();
  tool.sample_t_ns = input.sample_t_ns();
  tool.sample_counter = input.sample_counter();
  tool.device_flags = static_cast<std::uint16_t>(input.device_flags());
  tool.lost = input.lost();
  tool.write_failed = input.write_failed();
  tool.recentre = input.recentre();
  tool.clutch_open = input.clutch_open();
  tool.push = static_cast<PushAxis>(input.push());
  if (input.has_measured_delay_s()) tool.measured_delay_s = input.measured_delay_s();
  return true;
}

void set_output(const ToolTrace& tool, v1::ToolOutput& output) {
  output.set_tool_id(tool.tool_id);
  set_pose(tool.p_WG, tool.q_WG, *output.mutable_pose_wg());
  set_wrench(tool.f_computed_H_W, tool.t_computed_H_W, *output.mutable_wrench_unlimited_h_w());
  set_wrench(tool.f_H_W, tool.t_H_W, *output.mutable_wrench_h_w());
  for (int bit = 0; bit < 16; ++bit) {
    if (((tool.flags >> static_cast<unsigned>(bit)) & 1U) == 0) continue;
    output.add_flags(static_cast<v1::ToolFlag>(bit + 1));
  }
}

bool get_output(const v1::ToolOutput& output, ToolTrace& tool) {
  if (output.tool_id() != tool.tool_id || !get_pose(output.pose_wg(), tool.p_WG, tool.q_WG) ||
      !get_wrench(output.wrench_unlimited_h_w(), tool.f_computed_H_W, tool.t_computed_H_W) ||
      !get_wrench(output.wrench_h_w(), tool.f_H_W, tool.t_H_W)) {
    return false;
  }
  for (const int flag : output.flags()) {
    if (flag < 1 || flag > 16) return false;
    tool.flags = static_cast<std::uint16_t>(tool.flags | (1U << static_cast<unsigned>(flag - 1)));
  }
  return true;
}

}  // namespace

void to_record(const TickTrace& trace, v1::TickRecord& record) {
  record.Clear();
  record.set_tick(trace.tick);
  record.set_t_ns(trace.t_ns);
  record.set_dt_ns(trace.dt_ns);
  record.set_scene_id(trace.scene_id);
  record.set_loop_state(static_cast<v1::LoopState>(trace.loop_state));
  record.set_cause(static_cast<v1::Cause>(trace.cause));
  for (std::int32_t k = 0; k < trace.tool_count; ++k) {
    const ToolTrace& tool = trace.tools[static_cast<std::size_t>(k)];
    set_input(tool, *record.add_inputs());
    set_output(tool, *record.add_outputs());
  }
  v1::WorkBudget& budget = *record.mutable_budget();
  budget.set_level(trace.level);
  budget.set_substeps(trace.substeps);
  budget.set_sphere_tests(trace.sphere_tests);
  budget.set_qp_iterations(trace.qp_iterations);
  budget.set_work(trace.work_budget);
  record.set_state_hash(trace.state_hash);
  record.set_cpu_ns(trace.cpu_ns);
  record.set_skipped(trace.skipped);
  for (int bit = 0; bit < kOrderBits; ++bit) {
    if (((trace.orders >> static_cast<unsigned>(bit)) & 1U) == 0) continue;
    record.add_orders(static_cast<v1::Order>(bit + 1));
  }
  record.set_change(trace.change);
  record.set_first(trace.first);
}

bool to_trace(const v1::TickRecord& record, TickTrace& trace) {
  if (record.inputs_size() > static_cast<int>(kMaxTools) ||
      record.outputs_size() != record.inputs_size() || record.loop_state() < 1 ||
      record.loop_state() > static_cast<int>(LoopState::kOver) || record.cause() < 0 ||
      record.cause() > kMaxCause || !is_instant(record.t_ns()) || !is_instant(record.dt_ns())) {
    return false;
  }
  trace = {};
  trace.tick = record.tick();
  trace.t_ns = record.t_ns();
  trace.dt_ns = record.dt_ns();
  trace.scene_id = record.scene_id();
  trace.loop_state = static_cast<LoopState>(record.loop_state());
  trace.cause = static_cast<Cause>(record.cause());
  trace.tool_count = record.inputs_size();
  for (int k = 0; k < record.inputs_size(); ++k) {
    ToolTrace& tool = trace.tools[static_cast<std::size_t>(k)];
    if (!get_input(record.inputs(k), tool) || !get_output(record.outputs(k), tool)) return false;
  }
  trace.level = record.budget().level();
  trace.substeps = record.budget().substeps();
  trace.sphere_tests = record.budget().sphere_tests();
  trace.qp_iterations = record.budget().qp_iterations();
  trace.work_budget = record.budget().work();
  trace.state_hash = record.state_hash();
  trace.cpu_ns = record.cpu_ns();
  trace.skipped = record.skipped();
  for (const int order : record.orders()) {
    if (order < 1 || order > kOrderBits) return false;
    trace.orders =
        static_cast<std::uint16_t>(trace.orders | (1U << static_cast<unsigned>(order - 1)));
  }
  trace.change = record.change();
  trace.first = record.first();
  return true;
}

}  // namespace hapticd
