// See tick_record.h.
#include "server/recorder/tick_record.h"

#include <algorithm>
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

void set_wrench(const PlainWrench& F, v1::Wrench& wrench) {
  set(F.f, *wrench.mutable_f_n());
  set(F.t, *wrench.mutable_t_n_m());
}

bool get_wrench(const v1::Wrench& wrench, PlainWrench& F) {
  return get(wrench.f_n(), F.f) && get(wrench.t_n_m(), F.t);
}

/// A direction of D, or none.
bool is_push_axis(int axis) { return axis >= 0 && axis <= kPushAxes; }

void set_input(const ToolTick& tool, std::int64_t t_ns, v1::ToolInput& input) {
  const DeviceSample& sample = tool.sample;
  input.set_tool_id(tool.tool_id);
  if (tool.came) set_pose(sample.p_DH, sample.q_DH, *input.mutable_pose_dh());
  set_pose(tool.X_WH.p, tool.X_WH.q, *input.mutable_pose_wh());
  set(tool.V_WH.v, *input.mutable_twist_wh_w()->mutable_v_m_per_s());
  set(tool.V_WH.w, *input.mutable_twist_wh_w()->mutable_w_rad_per_s());
  input.set_buttons(sample.buttons);
  input.add_stiffness_scale(tool.stiffness.scale);
  input.set_age_ns(static_cast<std::uint64_t>(std::max<std::int64_t>(t_ns - sample.t_ns, 0)));
  input.set_held(tool.held);
  input.set_sample_t_ns(sample.t_ns);
  input.set_sample_counter(sample.counter);
  if (sample.has_velocity) {
    set(sample.v_DH_D, *input.mutable_twist_dh_d()->mutable_v_m_per_s());
    set(sample.w_DH_D, *input.mutable_twist_dh_d()->mutable_w_rad_per_s());
  }
  input.set_device_flags(sample.flags);
  input.set_lost(tool.lost);
  input.set_write_failed(tool.write_failed);
  input.set_recentre(tool.asked.recentre);
  input.set_clutch_open(tool.asked.clutch_open);
  input.set_push(static_cast<v1::Axis>(tool.asked.push));
  input.set_measure(static_cast<v1::Axis>(tool.asked.measure));
  if (!std::isnan(sample.measured_delay_s)) input.set_measured_delay_s(sample.measured_delay_s);
}

/// Whether the loop can reckon with it: see kMax_ns.
bool is_instant(std::int64_t t_ns) { return t_ns > -kMax_ns && t_ns < kMax_ns; }
bool is_instant(std::uint64_t t_ns) { return t_ns < std::uint64_t{kMax_ns}; }

bool get_input(const v1::ToolInput& input, ToolTick& tool) {
  DeviceSample& sample = tool.sample;
  tool.tool_id = input.tool_id();
  tool.came = input.has_pose_dh();
  if (tool.came && !get_pose(input.pose_dh(), sample.p_DH, sample.q_DH)) return false;
  sample.has_velocity = input.has_twist_dh_d();
  if (sample.has_velocity && (!get(input.twist_dh_d().v_m_per_s(), sample.v_DH_D) ||
                              !get(input.twist_dh_d().w_rad_per_s(), sample.w_DH_D))) {
    return false;
  }
  std::array<double, 1> scale{};
  if (!get_pose(input.pose_wh(), tool.X_WH.p, tool.X_WH.q) ||
      !get(input.twist_wh_w().v_m_per_s(), tool.V_WH.v) ||
      !get(input.twist_wh_w().w_rad_per_s(), tool.V_WH.w) || !get(input.stiffness_scale(), scale) ||
      input.device_flags() > 0xFFFFU || !is_instant(input.age_ns()) ||
      !is_instant(input.sample_t_ns()) || !is_push_axis(input.push()) ||
      !is_push_axis(input.measure())) {
    return false;
  }
  tool.stiffness.scale = scale[0];
  sample.buttons = input.buttons();
  tool.held = input.held();
  sample.t_ns = input.sample_t_ns();
  sample.counter = input.sample_counter();
  sample.flags = static_cast<std::uint16_t>(input.device_flags());
  tool.lost = input.lost();
  tool.write_failed = input.write_failed();
  tool.asked = {input.recentre(), input.clutch_open(), static_cast<PushAxis>(input.push()),
                static_cast<PushAxis>(input.measure())};
  if (input.has_measured_delay_s()) sample.measured_delay_s = input.measured_delay_s();
  return true;
}

void set_output(const ToolTick& tool, v1::ToolOutput& output) {
  output.set_tool_id(tool.tool_id);
  set_pose(tool.X_WG.p, tool.X_WG.q, *output.mutable_pose_wg());
  set_wrench(tool.F_computed_H_W, *output.mutable_wrench_unlimited_h_w());
  set_wrench(tool.F_written_H_W, *output.mutable_wrench_h_w());
  for (int bit = 0; bit < 16; ++bit) {
    if (((tool.flags >> static_cast<unsigned>(bit)) & 1U) == 0) continue;
    output.add_flags(static_cast<v1::ToolFlag>(bit + 1));
  }
}

bool get_output(const v1::ToolOutput& output, ToolTick& tool) {
  if (output.tool_id() != tool.tool_id || !get_pose(output.pose_wg(), tool.X_WG.p, tool.X_WG.q) ||
      !get_wrench(output.wrench_unlimited_h_w(), tool.F_computed_H_W) ||
      !get_wrench(output.wrench_h_w(), tool.F_written_H_W)) {
    return false;
  }
  for (const int flag : output.flags()) {
    if (flag < 1 || flag > 16) return false;
    tool.flags = static_cast<std::uint16_t>(tool.flags | (1U << static_cast<unsigned>(flag - 1)));
  }
  return true;
}

}  // namespace

void to_record(const Tick& tick, v1::TickRecord& record) {
  record.Clear();
  record.set_tick(tick.tick);
  record.set_t_ns(static_cast<std::uint64_t>(tick.t_ns));
  record.set_dt_ns(static_cast<std::uint64_t>(tick.dt_ns));
  record.set_scene_id(tick.scene_id);
  record.set_loop_state(static_cast<v1::LoopState>(tick.state));
  record.set_cause(static_cast<v1::Cause>(tick.cause));
  for (const ToolTick& tool : tick.tools) {
    set_input(tool, tick.t_ns, *record.add_inputs());
    set_output(tool, *record.add_outputs());
  }
  v1::WorkBudget& budget = *record.mutable_budget();
  budget.set_level(tick.budget.level);
  budget.set_substeps(tick.work.sub_steps);
  budget.set_sphere_tests(tick.work.sphere_tests);
  budget.set_qp_iterations(tick.work.qp_iterations);
  budget.set_work(tick.budget.work);
  record.set_cpu_ns(tick.times.cpu_ns);
  record.set_skipped(tick.skipped);
  for (int bit = 0; bit < kOrderBits; ++bit) {
    if (((tick.orders >> static_cast<unsigned>(bit)) & 1U) == 0) continue;
    record.add_orders(static_cast<v1::Order>(bit + 1));
  }
  record.set_change(tick.change);
  record.set_first(tick.first);
}

void add_shown(const Tick& tick, const SceneIndex& index, v1::TickRecord& record) {
  std::uint32_t sections = 1U << v1::SECTION_TOOLS | 1U << v1::SECTION_STRINGS |
                           1U << v1::SECTION_CONTACTS | 1U << v1::SECTION_ENERGY |
                           1U << v1::SECTION_QUALITY | 1U << v1::SECTION_STIFFNESS |
                           1U << v1::SECTION_GESTURES;
  if (tick.times.stages != StageTimes{}) sections |= 1U << v1::SECTION_STAGES;
  v1::State& shown = *record.mutable_shown();
  encode_state(tick, index, {sections, kShownContacts}, shown);
  // These stand in the record itself.
  shown.clear_tick();
  shown.clear_t_ns();
  shown.clear_loop_state();
  shown.clear_cause();
  shown.clear_scene_id();
  // And these in its inputs and outputs.
  for (v1::ToolState& tool : *shown.mutable_tools()) {
    tool.clear_tool_id();
    tool.clear_p_wh_m();
    tool.clear_q_wh();
    tool.clear_p_wg_m();
    tool.clear_q_wg();
    tool.clear_wrench_h_w();
    tool.clear_wrench_unlimited_h_w();
    tool.clear_flags();
  }
}

bool to_tick(const v1::TickRecord& record, Tick& tick) {
  if (record.inputs_size() > static_cast<int>(kMaxTools) ||
      record.outputs_size() != record.inputs_size() || record.loop_state() < 1 ||
      record.loop_state() > static_cast<int>(LoopState::kOver) || record.cause() < 0 ||
      record.cause() > kMaxCause || !is_instant(record.t_ns()) || !is_instant(record.dt_ns())) {
    return false;
  }
  static_cast<TickHead&>(tick) = {};
  tick.contacts.clear();
  tick.strings.clear();
  tick.string_forces.clear();
  tick.string_bends.clear();
  tick.tools.clear();
  tick.tick = record.tick();
  tick.t_ns = static_cast<std::int64_t>(record.t_ns());
  tick.dt_ns = static_cast<std::int64_t>(record.dt_ns());
  tick.scene_id = record.scene_id();
  tick.state = static_cast<LoopState>(record.loop_state());
  tick.cause = static_cast<Cause>(record.cause());
  for (int k = 0; k < record.inputs_size(); ++k) {
    ToolTick& tool = *tick.tools.append();
    tool = {};
    if (!get_input(record.inputs(k), tool) || !get_output(record.outputs(k), tool)) return false;
  }
  tick.budget.level = record.budget().level();
  tick.work.sub_steps = record.budget().substeps();
  tick.work.sphere_tests = record.budget().sphere_tests();
  tick.work.qp_iterations = static_cast<std::uint32_t>(record.budget().qp_iterations());
  tick.budget.work = record.budget().work();
  tick.times.cpu_ns = record.cpu_ns();
  tick.skipped = record.skipped();
  for (const int order : record.orders()) {
    if (order < 1 || order > kOrderBits) return false;
    tick.orders =
        static_cast<std::uint16_t>(tick.orders | (1U << static_cast<unsigned>(order - 1)));
  }
  tick.change = record.change();
  tick.first = record.first();
  return true;
}

}  // namespace hapticd
