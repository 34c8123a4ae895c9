// Truth: the bytes of the trace itself, after serialising and parsing.
#include "server/recorder/tick_record.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>

#include "tests/server/recorder/sample_ticks.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// Bit for bit: NaN equals itself, 0 and -0 differ.
template <std::size_t N>
bool same(const std::array<double, N>& a, const std::array<double, N>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), [](double x, double y) {
    return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
  });
}

bool same(const ToolTrace& a, const ToolTrace& b) {
  return a.tool_id == b.tool_id && a.buttons == b.buttons && a.flags == b.flags &&
         a.sample_came == b.sample_came && a.held == b.held && a.age_ns == b.age_ns &&
         a.has_velocity == b.has_velocity && a.lost == b.lost && a.write_failed == b.write_failed &&
         a.recentre == b.recentre && a.clutch_open == b.clutch_open && a.push == b.push &&
         a.device_flags == b.device_flags && a.sample_t_ns == b.sample_t_ns &&
         a.sample_counter == b.sample_counter && same(a.v_DH_D, b.v_DH_D) &&
         same(std::array{a.measured_delay_s}, std::array{b.measured_delay_s}) &&
         same(a.w_DH_D, b.w_DH_D) && a.stiffness_scale == b.stiffness_scale &&
         same(a.p_DH, b.p_DH) && same(a.q_DH, b.q_DH) && same(a.p_WH, b.p_WH) &&
         same(a.q_WH, b.q_WH) && same(a.v_WH_W, b.v_WH_W) && same(a.w_WH_W, b.w_WH_W) &&
         same(a.p_WG, b.p_WG) && same(a.q_WG, b.q_WG) && same(a.f_computed_H_W, b.f_computed_H_W) &&
         same(a.t_computed_H_W, b.t_computed_H_W) && same(a.f_H_W, b.f_H_W) &&
         same(a.t_H_W, b.t_H_W);
}

bool same(const TickTrace& a, const TickTrace& b) {
  bool all = a.tick == b.tick && a.t_ns == b.t_ns && a.dt_ns == b.dt_ns &&
             a.state_hash == b.state_hash && a.sphere_tests == b.sphere_tests &&
             a.qp_iterations == b.qp_iterations && a.work_budget == b.work_budget &&
             a.substeps == b.substeps && a.level == b.level && a.scene_id == b.scene_id &&
             a.cpu_ns == b.cpu_ns && a.loop_state == b.loop_state && a.cause == b.cause &&
             a.tool_count == b.tool_count;
  for (std::size_t k = 0; k < a.tools.size(); ++k) all = all && same(a.tools[k], b.tools[k]);
  return all;
}

}  // namespace

TEST_CASE("a recorded tick comes back with every bit, NaN payloads and -0 included") {
  SplitMix64 random(91);
  v1::TickRecord record;
  for (std::int64_t i = 0; i < scaled(100'000); ++i) {
    const TickTrace trace =
        any_tick(random, random.next(), static_cast<int>(random.below(kMaxTools + 1)));
    to_record(trace, record);
    v1::TickRecord parsed;
    REQUIRE(parsed.ParseFromString(record.SerializeAsString()));
    TickTrace back;
    REQUIRE(to_trace(parsed, back));
    REQUIRE(same(back, trace));
  }
}

TEST_CASE("a record that is no tick of ours is refused") {
  SplitMix64 random(92);
  v1::TickRecord good;
  to_record(any_tick(random, 1, 2), good);
  TickTrace trace;
  CHECK(to_trace(good, trace));
  v1::TickRecord bad = good;
  bad.mutable_inputs(0)->mutable_pose_wh()->mutable_q()->RemoveLast();
  CHECK_FALSE(to_trace(bad, trace));
  bad = good;
  bad.mutable_outputs()->RemoveLast();
  CHECK_FALSE(to_trace(bad, trace));
  bad = good;
  bad.set_loop_state(static_cast<v1::LoopState>(8));
  CHECK_FALSE(to_trace(bad, trace));
  bad = good;
  bad.set_cause(static_cast<v1::Cause>(kMaxCause + 1));
  CHECK_FALSE(to_trace(bad, trace));
  bad = good;
  bad.mutable_inputs(1)->clear_stiffness_scale();
  CHECK_FALSE(to_trace(bad, trace));
  bad = good;
  for (std::size_t k = 0; k < kMaxTools; ++k) *bad.add_inputs() = good.inputs(0);
  for (std::size_t k = 0; k < kMaxTools; ++k) *bad.add_outputs() = good.outputs(0);
  CHECK_FALSE(to_trace(bad, trace));
  bad = good;
  bad.mutable_inputs(0)->set_push(static_cast<v1::Axis>(kPushAxes + 1));
  CHECK_FALSE(to_trace(bad, trace));
  bad = good;
  bad.mutable_outputs(0)->add_flags(static_cast<v1::ToolFlag>(17));
  CHECK_FALSE(to_trace(bad, trace));
}

}  // namespace hapticd::test
