// Truth: each rule by hand, and over random streams a plain model of them: good samples pass as
// they are, the rest is bridged for two ticks, displacements add up to the way of the good poses.
#include "core/safety/input_watch.h"

#include <doctest/doctest.h>

#include <cmath>

#include "tests/core/safety/hostile.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

WatchedSample sample_at(std::uint64_t counter, const Vector3& p) {
  WatchedSample sample;
  sample.fresh = true;
  sample.counter = counter;
  sample.t_ns = static_cast<std::int64_t>(counter) * 1'000'000;
  sample.p_DH = to_array(p);
  return sample;
}

InputWatch started() {
  InputWatch state;
  (void)watch(sample_at(1, {0, 0, 0}), 0.0, {}, state);
  return state;
}

/// Makes `sample` useless in one of the ways a sample can be.
void spoil(WatchedSample& sample, SplitMix64& random) {
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
  InputLimits limits;
  InputWatch state;
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
    WatchedSample sample = sample_at(++counter, p);
    sample.q_DH = {random.uniform(0.6, 1.0), random.uniform(-0.5, 0.5), 0.1, 0.0};
    bool good = true;
    if (random.chance(0.2)) {
      good = false;
      switch (random.below(3)) {
        case 0:
          spoil(sample, random);
          break;
        case 1:
          sample.fresh = false;
          break;
        default:
          sample.counter = last_counter;  // seen before
          if (!any) good = true;
      }
    }
    const WatchedInput out = watch(sample, 0.0, limits, state);
    if (good) {
      if (any) way += p - last_good;
      last_good = p;
      last_counter = sample.counter;
      any = true;
      missed = 0;
    } else {
      ++missed;
    }
    const bool finite = out.X_DH.p.allFinite() && out.X_DH.q.coeffs().allFinite() &&
                        out.V_DH_D.v.allFinite() && out.V_DH_D.w.allFinite() &&
                        out.displacement_D.v.allFinite() && out.displacement_D.w.allFinite();
    const bool unit = std::abs(out.X_DH.q.norm() - 1.0) < 1e-12;
    const bool right = out.held == !good && out.usable == (any && missed <= kHeldTicks) &&
                       (out.fault == Cause::kNone) == (missed <= kHeldTicks);
    const bool place = !any || out.X_DH.p == last_good;
    if (!(finite && unit && right && place)) FAIL("tick " << i);
    way -= out.displacement_D.v;
    if (!(way.norm() <= 1e-9)) FAIL("the way is lost in tick " << i);
  }
}

TEST_CASE("bad numbers are told from silence") {
  InputWatch state = started();
  WatchedSample bad = sample_at(2, {0, 0, 0});
  bad.p_DH[1] = std::numeric_limits<double>::quiet_NaN();
  CHECK(watch(bad, 0.0, {}, state).fault == Cause::kNone);
  CHECK(watch(bad, 0.0, {}, state).usable);
  CHECK(watch(bad, 0.0, {}, state).fault == Cause::kNotFinite);
  CHECK(state.bad_total == 3);
  CHECK(state.held_total == 2);
  InputWatch silent = started();
  for (int k = 0; k < kHeldTicks; ++k) CHECK(watch({}, 0.0, {}, silent).fault == Cause::kNone);
  CHECK(watch({}, 0.0, {}, silent).fault == Cause::kInputStale);
  CHECK(watch(sample_at(9, {0, 0, 0}), 0.0, {}, silent).fault == Cause::kNone);
}

TEST_CASE("under a virtual clock silence lasts as long as it likes, nonsense does not") {
  InputLimits limits;
  limits.stale_ticks = kAnyTicks;
  InputWatch state = started();
  for (int k = 0; k < 10'000; ++k) REQUIRE(watch({}, 0.0, limits, state).usable);
  WatchedSample bad = sample_at(2, {0, 0, 0});
  bad.q_DH = {};
  (void)watch(bad, 0.0, limits, state);
  (void)watch(bad, 0.0, limits, state);
  CHECK(watch(bad, 0.0, limits, state).fault == Cause::kNotFinite);
}

TEST_CASE("before the first good sample nothing is usable") {
  InputWatch state;
  CHECK_FALSE(watch({}, 0.0, {}, state).usable);
  const WatchedInput first = watch(sample_at(5, {1, 2, 3}), 0.0, {}, state);
  CHECK(first.usable);
  CHECK(first.V_DH_D.v == Vector3::Zero());
  CHECK(first.displacement_D.v == Vector3::Zero());
}

TEST_CASE("the norm of a quaternion may be off by a factor of two, no more") {
  for (const double norm : {0.499, 0.501, 1.999, 2.001}) {
    InputWatch state = started();
    WatchedSample sample = sample_at(2, {0, 0, 0});
    sample.q_DH = {0.6 * norm, 0, 0.8 * norm, 0};
    const WatchedInput out = watch(sample, 0.0, {}, state);
    const bool inside = norm > 0.5 && norm < 2.0;
    CHECK(out.held == !inside);
    if (inside) CHECK(out.X_DH.q.y() == doctest::Approx(0.8));
  }
}

TEST_CASE("velocity is that of the samples' own times, or the device's") {
  InputWatch state = started();
  WatchedSample sample = sample_at(3, {2e-3, 0, 0});  // one sample lost: 2 ms
  sample.q_DH = {std::cos(0.005), 0, 0, std::sin(0.005)};
  const WatchedInput out = watch(sample, 0.0, {}, state);
  CHECK(out.V_DH_D.v.x() == doctest::Approx(1.0));
  CHECK(out.V_DH_D.w.z() == doctest::Approx(5.0));
  CHECK(out.elapsed_s == doctest::Approx(2e-3));
  CHECK(out.displacement_D.w.z() == doctest::Approx(0.01));
  sample = sample_at(4, {2e-3, 0, 0});
  sample.has_velocity = true;
  sample.v_DH_D = {0.5, 0, 0};
  CHECK(watch(sample, 0.0, {}, state).V_DH_D.v.x() == 0.5);
  // By the device's own clock the same instant twice: no velocity from no time.
  InputLimits own_clock;
  own_clock.report_interval_ns = 0;
  sample = sample_at(5, {3e-3, 0, 0});
  sample.t_ns -= 1'000'000;
  const WatchedInput twice = watch(sample, 0.0, own_clock, state);
  CHECK(twice.V_DH_D.v == Vector3::Zero());
  CHECK(twice.displacement_D.v.x() == doctest::Approx(1e-3));
}

TEST_CASE("the velocity trip looks at the way and at the tachometer, whichever is faster") {
  for (const double speed : {2.99, 3.01}) {
    const Cause expected = speed > 3.0 ? Cause::kVelocityTrip : Cause::kNone;
    InputWatch by_way = started();
    CHECK(watch(sample_at(2, {speed * 1e-3, 0, 0}), 0.0, {}, by_way).fault == expected);
    CHECK(by_way.fast_total == (speed > 3.0 ? 1 : 0));
    InputWatch by_device = started();
    WatchedSample sample = sample_at(2, {0, 0, 0});
    sample.has_velocity = true;
    sample.v_DH_D = {0, speed, 0};
    CHECK(watch(sample, 0.0, {}, by_device).fault == expected);
    // A tachometer that stands still does not hide a jump.
    InputWatch hidden = started();
    sample = sample_at(2, {0, 0, speed * 1e-3});
    sample.has_velocity = true;
    CHECK(watch(sample, 0.0, {}, hidden).fault == expected);
  }
}

TEST_CASE("a pose that repeats for 200 ms under force is a stuck sensor; without force it rests") {
  InputLimits limits;
  limits.stuck_after_ns = 200'000'000;
  for (const double force : {0.0, 0.1, 0.3}) {
    InputWatch state = started();
    std::uint64_t tripped = 0;
    for (std::uint64_t k = 2; k < 1000 && tripped == 0; ++k) {
      if (watch(sample_at(k, {0, 0, 0}), force, limits, state).fault == Cause::kInputStuck) {
        tripped = k;
      }
    }
    CHECK(tripped == (force > 0.2 ? 202 : 0));
  }
  // One changed bit is a sign of life.
  InputWatch alive = started();
  for (std::uint64_t k = 2; k < 2000; ++k) {
    const Vector3 p{0, 0, k % 150 == 0 ? 5e-324 : 0.0};
    REQUIRE(watch(sample_at(k, p), 5.0, limits, alive).fault == Cause::kNone);
  }
  // Not looked for where there is no sensor.
  InputWatch scripted = started();
  for (std::uint64_t k = 2; k < 2000; ++k) {
    REQUIRE(watch(sample_at(k, {0, 0, 0}), 5.0, {}, scripted).fault == Cause::kNone);
  }
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
