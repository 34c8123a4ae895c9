// Truth: the bytes of the tick itself, after serialising and parsing.
#include "server/recorder/tick_record.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <memory>

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

bool same(const PlainPose& a, const PlainPose& b) { return same(a.p, b.p) && same(a.q, b.q); }
bool same(const PlainTwist& a, const PlainTwist& b) { return same(a.v, b.v) && same(a.w, b.w); }
bool same(const PlainWrench& a, const PlainWrench& b) { return same(a.f, b.f) && same(a.t, b.t); }

bool same(const DeviceSample& a, const DeviceSample& b) {
  return a.t_ns == b.t_ns && a.counter == b.counter && same(a.p_DH, b.p_DH) &&
         same(a.q_DH, b.q_DH) && same(a.v_DH_D, b.v_DH_D) && same(a.w_DH_D, b.w_DH_D) &&
         same(std::array{a.measured_delay_s}, std::array{b.measured_delay_s}) &&
         a.buttons == b.buttons && a.flags == b.flags && a.has_velocity == b.has_velocity;
}

bool same(const ToolTick& a, const ToolTick& b) {
  return a.tool_id == b.tool_id && a.flags == b.flags && same(a.sample, b.sample) &&
         a.came == b.came && a.held == b.held && a.lost == b.lost &&
         a.write_failed == b.write_failed && a.asked.recentre == b.asked.recentre &&
         a.asked.clutch_open == b.asked.clutch_open && a.asked.push == b.asked.push &&
         a.asked.measure == b.asked.measure && a.stiffness.scale == b.stiffness.scale &&
         same(a.X_WH, b.X_WH) && same(a.V_WH, b.V_WH) && same(a.X_WG, b.X_WG) &&
         same(a.F_computed_H_W, b.F_computed_H_W) && same(a.F_written_H_W, b.F_written_H_W);
}

bool same(const Tick& a, const Tick& b) {
  bool all = a.tick == b.tick && a.t_ns == b.t_ns && a.dt_ns == b.dt_ns &&
             a.work.sphere_tests == b.work.sphere_tests &&
             a.work.qp_iterations == b.work.qp_iterations && a.budget.work == b.budget.work &&
             a.work.sub_steps == b.work.sub_steps && a.budget.level == b.budget.level &&
             a.scene_id == b.scene_id && a.times.cpu_ns == b.times.cpu_ns && a.state == b.state &&
             a.cause == b.cause && a.skipped == b.skipped && a.change == b.change &&
             a.orders == b.orders && a.first == b.first && a.tools.size() == b.tools.size();
  for (std::size_t k = 0; all && k < a.tools.size(); ++k) all = same(a.tools[k], b.tools[k]);
  return all;
}

}  // namespace

TEST_CASE("a recorded tick comes back with every bit, NaN payloads and -0 included") {
  SplitMix64 random(91);
  v1::TickRecord record;
  const auto back = std::make_unique<Tick>();
  for (std::int64_t i = 0; i < scaled(100'000); ++i) {
    const Tick tick =
        any_tick(random, random.next(), static_cast<int>(random.below(kMaxTools + 1)));
    to_record(tick, record);
    v1::TickRecord parsed;
    REQUIRE(parsed.ParseFromString(record.SerializeAsString()));
    REQUIRE(to_tick(parsed, *back));
    REQUIRE(same(*back, tick));
  }
}

TEST_CASE(
    "a recording shows the times of the stages, but for those of virtual time, which has none") {
  const auto tick = std::make_unique<Tick>();
  v1::TickRecord record;
  add_shown(*tick, {}, record);
  CHECK_FALSE(record.shown().has_timing());
  tick->times.stages[static_cast<std::size_t>(Stage::kCollision)] = 1234;
  add_shown(*tick, {}, record);
  REQUIRE(record.shown().timing().stages_size() > 1);
  CHECK(record.shown().timing().stages(1).stage() == v1::STAGE_COLLISION);
  CHECK(record.shown().timing().stages(1).last_ns() == 1234);
}

TEST_CASE("a record that is no tick of ours is refused") {
  SplitMix64 random(92);
  v1::TickRecord good;
  to_record(any_tick(random, 1, 2), good);
  const auto tick = std::make_unique<Tick>();
  CHECK(to_tick(good, *tick));
  v1::TickRecord bad = good;
  bad.mutable_inputs(0)->mutable_pose_wh()->mutable_q()->RemoveLast();
  CHECK_FALSE(to_tick(bad, *tick));
  bad = good;
  bad.mutable_outputs()->RemoveLast();
  CHECK_FALSE(to_tick(bad, *tick));
  bad = good;
  bad.set_loop_state(static_cast<v1::LoopState>(8));
  CHECK_FALSE(to_tick(bad, *tick));
  bad = good;
  bad.set_cause(static_cast<v1::Cause>(kMaxCause + 1));
  CHECK_FALSE(to_tick(bad, *tick));
  bad = good;
  bad.mutable_inputs(1)->clear_stiffness_scale();
  CHECK_FALSE(to_tick(bad, *tick));
  bad = good;
  for (std::size_t k = 0; k < kMaxTools; ++k) *bad.add_inputs() = good.inputs(0);
  for (std::size_t k = 0; k < kMaxTools; ++k) *bad.add_outputs() = good.outputs(0);
  CHECK_FALSE(to_tick(bad, *tick));
  bad = good;
  bad.mutable_inputs(0)->set_push(static_cast<v1::Axis>(kPushAxes + 1));
  CHECK_FALSE(to_tick(bad, *tick));
  bad = good;
  bad.mutable_outputs(0)->add_flags(static_cast<v1::ToolFlag>(17));
  CHECK_FALSE(to_tick(bad, *tick));
}

}  // namespace hapticd::test
