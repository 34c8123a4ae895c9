// The guards in a row, as the loop runs them: samples and requests of every kind through pose
// guard, loop states and output stage. Truth: the law itself: no force in the tick of a fault nor
// after it until Clear, and none from the third tick without a good sample.
#include <doctest/doctest.h>

#include <cmath>

#include "core/safety/loop_state.h"
#include "core/safety/output_stage.h"
#include "core/safety/pose_guard.h"
#include "tests/core/safety/hostile.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

struct Chain {
  GuardLimits guard_limits;
  PoseGuard guard;
  LoopMachine machine;
  SafetyLimits limits;
  SafetyState state;
};

struct ChainTick {
  DeviceSample sample;
  bool came = true;
  LoopInput requests;
  Vector3 f_D;
  std::int64_t now_ns = 0;
};

SafetyOutput run(const ChainTick& tick, Chain& chain) {
  const double written = to_vector(chain.state.f_H_D).norm();
  const JudgedPose seen =
      judge(tick.came ? &tick.sample : nullptr, written, chain.guard_limits, chain.guard);
  LoopInput in = tick.requests;
  if (in.fault == Cause::kNone && latches(seen.fault, true, false)) in.fault = seen.fault;
  in.calibrated = in.calibrated && chain.guard.has_pose;
  const LoopOutput loop = advance(in, chain.machine);
  SafetyInput safety;
  safety.now_ns = tick.now_ns;
  safety.dt_s = in.dt_s;
  safety.enable = loop.gain > 0.0 && seen.usable;
  safety.gain = loop.gain;
  safety.F_H_D.f = tick.f_D;
  safety.V_DH_D = seen.V_DH_D;
  safety.displacement_D = seen.displacement_D;
  return limit(safety, chain.limits, chain.state);
}

}  // namespace

TEST_CASE("no force in the tick of a fault nor after it until Clear, whatever happens meanwhile") {
  SplitMix64 random(71);
  Chain chain;
  Vector3 p = Vector3::Zero();
  bool latched = false;
  int silent = 0;
  std::int64_t forceful = 0;
  std::int64_t faults = 0;
  std::int64_t bad_for = 0;
  const std::int64_t count = scaled(10'000'000);
  for (std::int64_t i = 0; i < count; ++i) {
    p += to_vector(random.direction()) * 1e-4;
    ChainTick tick;
    tick.now_ns = i * 1'000'000;
    tick.sample.counter = static_cast<std::uint64_t>(i) + 1;
    tick.sample.t_ns = tick.now_ns;
    tick.sample.p_DH = to_array(p);
    if (bad_for == 0 && random.chance(0.002)) bad_for = static_cast<std::int64_t>(random.below(6));
    const bool bad = bad_for > 0;
    if (bad) {
      --bad_for;
      tick.sample.p_DH[random.below(3)] = no_number(random);
    }
    LoopInput& in = tick.requests;
    in.dt_s = 1e-3;
    in.attached = !random.chance(1e-4);
    in.calibrated = !random.chance(1e-4);
    in.contact_free = true;
    in.engages_itself = true;
    in.stop = random.chance(1e-4);
    in.clear = random.chance(0.02);
    if (random.chance(2e-4)) in.fault = static_cast<Cause>(1 + random.below(kMaxCause));
    tick.f_D = random.chance(0.999) ? Vector3(wild_vector(random, 10.0))
                                    : Vector3(1.0, no_number(random), 0.0);
    const SafetyOutput out = run(tick, chain);
    const double force = to_vector(out.f_H_D).norm();
    silent = bad ? silent + 1 : 0;
    const bool must_be_silent = latched || silent > 2 || in.stop || in.fault != Cause::kNone;
    if (must_be_silent && force > 0.0) FAIL("force in tick " << i);
    if (chain.machine.state == LoopState::kFault && !latched) ++faults;
    latched = chain.machine.state == LoopState::kFault;
    forceful += force > 0.0 ? 1 : 0;
  }
  CHECK(forceful > count / 4);
  CHECK(faults > count / 10'000);
}

TEST_CASE("under a steady force, the third tick without a good sample is the first without force") {
  for (const bool silence : {true, false}) {
    Chain chain;
    ChainTick tick;
    tick.requests.attached = tick.requests.calibrated = tick.requests.contact_free = true;
    tick.requests.engages_itself = true;
    tick.requests.dt_s = 1e-3;
    tick.f_D = {1, 0, 0};
    for (int k = 0; k < 300; ++k) {
      ++tick.sample.counter;
      tick.sample.t_ns += 1'000'000;
      (void)run(tick, chain);
    }
    if (silence) tick.came = false;
    if (!silence) tick.sample.q_DH = {};
    CHECK(run(tick, chain).f_H_D[0] == doctest::Approx(1.0));
    CHECK(run(tick, chain).f_H_D[0] == doctest::Approx(1.0));
    CHECK(run(tick, chain).f_H_D[0] == 0.0);
    CHECK(chain.machine.state == LoopState::kFault);
    CHECK(chain.machine.cause == (silence ? Cause::kInputStale : Cause::kNotFinite));
  }
}

}  // namespace hapticd::test
