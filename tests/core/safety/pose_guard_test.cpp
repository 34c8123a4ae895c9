// Truth: each rule by hand, and over random streams a plain model of them: good samples pass as
// they are, the rest is bridged for two ticks, displacements add up to the way of the good poses.
#include "core/safety/pose_guard.h"

#include <doctest/doctest.h>

#include <cmath>

#include "tests/core/safety/hostile.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

DeviceSample sample_at(std::uint64_t counter, const Vector3& p) {
  DeviceSample sample;
  sample.counter = counter;
  sample.t_ns = static_cast<std::int64_t>(counter) * 1'000'000;
  sample.p_DH = to_array(p);
  return sample;
}

/// A sample that came.
JudgedPose judged(const DeviceSample& sample, double force_written, const GuardLimits& limits,
                  PoseGuard& guard) {
  return judge(&sample, force_written, limits, guard);
}

PoseGuard started() {
  PoseGuard state;
  (void)judged(sample_at(1, {0, 0, 0}), 0.0, {}, state);
  return state;
}

bool can_be_computed_with(const JudgedPose& out) {
  return out.X_DH.p.allFinite() && out.X_DH.q.coeffs().allFinite() && out.V_DH_D.v.allFinite() &&
         out.V_DH_D.w.allFinite() && out.displacement_D.v.allFinite() &&
         out.displacement_D.w.allFinite() && std::abs(out.X_DH.q.norm() - 1.0) < 1e-12;
}

/// Makes `sample` useless in one of the ways a sample can be.
void spoil(DeviceSample& sample, SplitMix64& random) {
  const std::size_t k = random.below(3);
  switch (random.below(6)) {
    case 0:
      sample.p_DH[k] = no_number(random);
      break;
    case 1:
      sample.q_DH[k] = no_number(random);
      break;
    case 2:
      sample.q_DH = {0.1 * random.uniform(), 0.2, 0, 0};
      break;
    case 3:
      sample.q_DH = {1e308, 0, 0, 1e308};
      break;
    case 4:
      sample.p_DH[k] = 1e300 * (random.chance(0.5) ? 1 : -1);
      break;
    default:
      sample.has_velocity = true;
      sample.w_DH_D[k] = no_number(random);
  }
}

}  // namespace

TEST_CASE(
    "whatever a device sends, what is computed with is finite, and bridged for two ticks only") {
  SplitMix64 random(51);
  GuardLimits limits;
  PoseGuard state;
  Vector3 p = Vector3::Zero();
  Vector3 last_good = Vector3::Zero();
  Vector3 way = Vector3::Zero();
  bool any = false;
  int missed = 0;
  std::uint64_t counter = 0;
  std::uint64_t last_counter = 0;
  const std::int64_t count = scaled(10'000'000);
  for (std::int64_t i = 0; i < count; ++i) {
    p += to_vector(random.direction()) * 1e-4;
    DeviceSample sample = sample_at(++counter, p);
    sample.q_DH = {random.uniform(0.6, 1.0), random.uniform(-0.5, 0.5), 0.1, 0.0};
    bool good = true;
    bool came = true;
    if (random.chance(0.2)) {
      good = false;
      switch (random.below(3)) {
        case 0:
          spoil(sample, random);
          break;
        case 1:
          came = false;
          break;
        default:
          sample.counter = last_counter;  // seen before
          if (!any) good = true;
      }
    }
    const JudgedPose out = judge(came ? &sample : nullptr, 0.0, limits, state);
    if (good) {
      if (any) way += p - last_good;
      last_good = p;
      last_counter = sample.counter;
      any = true;
      missed = 0;
    } else {
      ++missed;
    }
    const bool right = out.held == !good && out.usable == (any && missed <= kHeldTicks) &&
                       (out.fault == Cause::kNone) == (missed <= kHeldTicks);
    const bool place = !any || out.X_DH.p == last_good;
    if (!(can_be_computed_with(out) && right && place)) FAIL("tick " << i);
    way -= out.displacement_D.v;
    if (!(way.norm() <= 1e-9)) FAIL("the way is lost in tick " << i);
  }
}

TEST_CASE("bad numbers are told from silence") {
  PoseGuard state = started();
  DeviceSample bad = sample_at(2, {0, 0, 0});
  bad.p_DH[1] = std::numeric_limits<double>::quiet_NaN();
  CHECK(judged(bad, 0.0, {}, state).fault == Cause::kNone);
  CHECK(judged(bad, 0.0, {}, state).usable);
  CHECK(judged(bad, 0.0, {}, state).fault == Cause::kNotFinite);
  CHECK(state.bad_total == 3);
  CHECK(state.held_total == 2);
  PoseGuard silent = started();
  for (int k = 0; k < kHeldTicks; ++k) CHECK(judge(nullptr, 0.0, {}, silent).fault == Cause::kNone);
  CHECK(judge(nullptr, 0.0, {}, silent).fault == Cause::kInputStale);
  CHECK(judged(sample_at(9, {0, 0, 0}), 0.0, {}, silent).fault == Cause::kNone);
}

TEST_CASE("under a virtual clock silence lasts as long as it likes, nonsense does not") {
  GuardLimits limits;
  limits.stale_ticks = kAnyTicks;
  PoseGuard state = started();
  for (int k = 0; k < 10'000; ++k) REQUIRE(judge(nullptr, 0.0, limits, state).usable);
  DeviceSample bad = sample_at(2, {0, 0, 0});
  bad.q_DH = {};
  (void)judged(bad, 0.0, limits, state);
  (void)judged(bad, 0.0, limits, state);
  CHECK(judged(bad, 0.0, limits, state).fault == Cause::kNotFinite);
}

TEST_CASE("before the first good sample nothing is usable") {
  PoseGuard state;
  CHECK_FALSE(judge(nullptr, 0.0, {}, state).usable);
  const JudgedPose first = judged(sample_at(5, {1, 2, 3}), 0.0, {}, state);
  CHECK(first.usable);
  CHECK(first.V_DH_D.v == Vector3::Zero());
  CHECK(first.displacement_D.v == Vector3::Zero());
}

TEST_CASE("the norm of a quaternion may be off by a factor of two, no more") {
  for (const double norm : {0.499, 0.501, 1.999, 2.001}) {
    PoseGuard state = started();
    DeviceSample sample = sample_at(2, {0, 0, 0});
    sample.q_DH = {0.6 * norm, 0, 0.8 * norm, 0};
    const JudgedPose out = judged(sample, 0.0, {}, state);
    const bool inside = norm > 0.5 && norm < 2.0;
    CHECK(out.held == !inside);
    if (inside) CHECK(out.X_DH.q.y() == doctest::Approx(0.8));
  }
}

TEST_CASE("before any good pose nothing that is bad is ever usable") {
  PoseGuard guard;
  DeviceSample bad = sample_at(1, {0, 0, 0});
  bad.p_DH[0] = std::numeric_limits<double>::quiet_NaN();
  for (int k = 1; k <= 5; ++k) {
    const JudgedPose out = judged(bad, 0.0, {}, guard);
    CHECK_FALSE(out.usable);
    CHECK((out.fault == Cause::kNotFinite) == (k > kHeldTicks));
  }
  CHECK(judged(sample_at(2, {0, 0, 0}), 0.0, {}, guard).usable);
}

TEST_CASE("one good sample between bad ones starts the count of held ticks afresh") {
  PoseGuard guard = started();
  std::uint64_t counter = 1;
  for (int round = 0; round < 10; ++round) {
    for (int k = 0; k < kHeldTicks; ++k) {
      DeviceSample bad = sample_at(++counter, {0, 0, 0});
      bad.q_DH = {};
      const JudgedPose out = judged(bad, 0.0, {}, guard);
      CHECK(out.held);
      CHECK(out.usable);
    }
    CHECK_FALSE(judged(sample_at(++counter, {0, 0, 0}), 0.0, {}, guard).held);
  }
}

TEST_CASE("denormal and negative zero numbers are ordinary ones, 1e308 is not") {
  constexpr double kDenormal = std::numeric_limits<double>::denorm_min();
  PoseGuard guard = started();
  DeviceSample sample = sample_at(2, {kDenormal, -0.0, -kDenormal});
  sample.q_DH = {1, -0.0, kDenormal, 0};
  CHECK_FALSE(judged(sample, 0.0, {}, guard).held);
  for (std::size_t k = 0; k < 7; ++k) {
    for (const double large : {1e308, -1e308}) {
      DeviceSample bad = sample_at(3, {0, 0, 0});
      (k < 3 ? bad.p_DH[k] : bad.q_DH[k - 3]) = large;
      CHECK(judged(bad, 0.0, {}, guard).held);
      guard.bad_ticks = guard.missed_ticks = 0;
    }
  }
}

TEST_CASE("a pose out of reach is refused, wherever the limit is") {
  for (const double reach : {1e7, 2.0, 1e-3, -5.0}) {
    CAPTURE(reach);
    GuardLimits limits;
    limits.reach = reach;
    limits.velocity_trip = 1e12;
    PoseGuard guard;
    CHECK(judged(sample_at(1, {0, 0.6 * reach, -0.79 * reach}), 0.0, limits, guard).usable ==
          (reach >= 0.0));
    CHECK(judged(sample_at(2, {0, 0.6 * reach, -0.81 * reach}), 0.0, limits, guard).held);
  }
}

TEST_CASE("a held pose that the map has moved out of reach is forgotten, and that is a fault") {
  GuardLimits limits;
  limits.stale_ticks = kAnyTicks;
  PoseGuard guard;
  CHECK(judged(sample_at(1, {0, 3, 0}), 0.0, limits, guard).usable);
  limits.reach = 2.0;
  const JudgedPose out = judge(nullptr, 0.0, limits, guard);
  CHECK_FALSE(out.usable);
  CHECK(out.fault == Cause::kNotFinite);
  CHECK_FALSE(guard.has_pose);
  CHECK_FALSE(judge(nullptr, 0.0, limits, guard).usable);
  // A good one begins anew, without a jump from where the last was.
  const JudgedPose anew = judged(sample_at(2, {0, 1, 0}), 0.0, limits, guard);
  CHECK(anew.usable);
  CHECK(anew.displacement_D.v == Vector3::Zero());
}

TEST_CASE("velocity is that of the samples' own times, or the device's") {
  PoseGuard state = started();
  DeviceSample sample = sample_at(3, {2e-3, 0, 0});  // one sample lost: 2 ms
  sample.q_DH = {std::cos(0.005), 0, 0, std::sin(0.005)};
  const JudgedPose out = judged(sample, 0.0, {}, state);
  CHECK(out.V_DH_D.v.x() == doctest::Approx(1.0));
  CHECK(out.V_DH_D.w.z() == doctest::Approx(5.0));
  CHECK(out.elapsed_s == doctest::Approx(2e-3));
  CHECK(out.displacement_D.w.z() == doctest::Approx(0.01));
  sample = sample_at(4, {2e-3, 0, 0});
  sample.has_velocity = true;
  sample.v_DH_D = {0.5, 0, 0};
  CHECK(judged(sample, 0.0, {}, state).V_DH_D.v.x() == 0.5);
  // By the device's own clock the same instant twice: no velocity from no time.
  GuardLimits own_clock;
  own_clock.report_interval_ns = 0;
  sample = sample_at(5, {3e-3, 0, 0});
  sample.t_ns -= 1'000'000;
  const JudgedPose twice = judged(sample, 0.0, own_clock, state);
  CHECK(twice.V_DH_D.v == Vector3::Zero());
  CHECK(twice.displacement_D.v.x() == doctest::Approx(1e-3));
}

TEST_CASE("the velocity trip looks at the way and at the tachometer, whichever is faster") {
  for (const double speed : {2.99, 3.01}) {
    const Cause expected = speed > 3.0 ? Cause::kVelocityTrip : Cause::kNone;
    PoseGuard by_way = started();
    CHECK(judged(sample_at(2, {speed * 1e-3, 0, 0}), 0.0, {}, by_way).fault == expected);
    CHECK(by_way.fast_total == (speed > 3.0 ? 1 : 0));
    PoseGuard by_device = started();
    DeviceSample sample = sample_at(2, {0, 0, 0});
    sample.has_velocity = true;
    sample.v_DH_D = {0, speed, 0};
    CHECK(judged(sample, 0.0, {}, by_device).fault == expected);
    // A tachometer that stands still does not hide a jump.
    PoseGuard hidden = started();
    sample = sample_at(2, {0, 0, speed * 1e-3});
    sample.has_velocity = true;
    CHECK(judged(sample, 0.0, {}, hidden).fault == expected);
  }
}

TEST_CASE("a pose that repeats for 200 ms under force is a stuck sensor; without force it rests") {
  GuardLimits limits;
  limits.stuck_after_ns = 200'000'000;
  for (const double force : {0.0, 0.1, 0.3}) {
    PoseGuard state = started();
    std::uint64_t tripped = 0;
    for (std::uint64_t k = 2; k < 1000 && tripped == 0; ++k) {
      if (judged(sample_at(k, {0, 0, 0}), force, limits, state).fault == Cause::kInputStuck) {
        tripped = k;
      }
    }
    CHECK(tripped == (force > 0.2 ? 202 : 0));
  }
  // One changed bit is a sign of life.
  PoseGuard alive = started();
  for (std::uint64_t k = 2; k < 2000; ++k) {
    const Vector3 p{0, 0, k % 150 == 0 ? 5e-324 : 0.0};
    REQUIRE(judged(sample_at(k, p), 5.0, limits, alive).fault == Cause::kNone);
  }
  // Not looked for where there is no sensor.
  PoseGuard scripted = started();
  for (std::uint64_t k = 2; k < 2000; ++k) {
    REQUIRE(judged(sample_at(k, {0, 0, 0}), 5.0, {}, scripted).fault == Cause::kNone);
  }
}

TEST_CASE("a stream that pauses is stale before it is a fault, and may take its time to begin") {
  GuardLimits limits;
  limits.fading_ticks = 50;
  limits.may_wait = true;
  PoseGuard guard;
  for (int tick = 0; tick < 10'000; ++tick) {
    const JudgedPose waits = judge(nullptr, 0.0, limits, guard);
    REQUIRE(waits.fault == Cause::kNone);
    REQUIRE_FALSE(waits.usable);
    REQUIRE_FALSE(waits.stale);
  }
  std::uint64_t counter = 1;
  for (const int gap : {1, 2, 3, 52, 53, 60}) {
    CAPTURE(gap);
    CHECK(judged(sample_at(counter, {0, 0, 0.01}), 0.0, limits, guard).fault == Cause::kNone);
    for (int missed = 1; missed <= gap; ++missed) {
      const JudgedPose out = judge(nullptr, 0.0, limits, guard);
      CHECK(out.stale == (missed > 2 && missed <= 52));
      CHECK(out.usable == (missed <= 52));
      CHECK(out.fault == (missed <= 52 ? Cause::kNone : Cause::kInputStale));
      CHECK(out.X_DH.p.z() == 0.01);
    }
    counter += 100;
  }
  // Others wait for nothing.
  PoseGuard sensor;
  GuardLimits of_sensor;
  Cause fault = Cause::kNone;
  for (int tick = 0; tick < 3; ++tick) fault = judge(nullptr, 0.0, of_sensor, sensor).fault;
  CHECK(fault == Cause::kInputStale);
}

TEST_CASE("a device slower than the loop is bridged for two of its own samples") {
  CHECK(bridged_ticks(1000, 1000) == 2);
  CHECK(bridged_ticks(4000, 1000) == 2);
  CHECK(bridged_ticks(500, 1000) == 4);
  CHECK(bridged_ticks(1000, 10'000) == 20);
  CHECK(bridged_ticks(0, 1000) == 2'000'000);
  CHECK(bridged_ticks(std::numeric_limits<double>::quiet_NaN(), 1000) == 2);
}

}  // namespace hapticd::test
