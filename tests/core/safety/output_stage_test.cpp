// Truth: the laws themselves, in long double, over random ticks of every kind: what is written is
// finite, within the peak, grows no faster than the slew, falls at once, is zero when disabled or
// fed with what is no number, keeps its direction, and expires.
#include "core/safety/output_stage.h"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "tests/core/safety/hostile.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

using Long3 = Eigen::Matrix<long double, 3, 1>;

Long3 to_long(const Array3& a) { return to_vector(a).cast<long double>(); }

struct HostileTick {
  SafetyInput input;
  bool finite = true;
};

/// A tick of any kind; about one in ten carries something that is no number.
HostileTick hostile_tick(SplitMix64& random, std::int64_t now_ns) {
  HostileTick tick;
  SafetyInput& in = tick.input;
  in.now_ns = random.chance(0.01) ? std::numeric_limits<std::int64_t>::max() - 3 : now_ns;
  in.dt_s = random.chance(0.8) ? 1e-3 : std::abs(wild(random, 0.02));
  if (random.chance(0.05)) in.dt_s = random.chance(0.5) ? 0.0 : -in.dt_s;
  in.hold_s = random.chance(0.9) ? 1e-3 : wild(random, 1e-3);
  in.enable = random.chance(0.9);
  in.gain = random.chance(0.7) ? 1.0 : wild(random, 1.0);
  in.F_H_D = {wild_vector(random, 50.0), wild_vector(random, 1.0)};
  in.V_DH_D = {wild_vector(random, 1.0), wild_vector(random, 10.0)};
  in.displacement_D = {wild_vector(random, 1e-3), wild_vector(random, 1e-2)};
  in.budget = random.chance(0.8) ? 0.0 : wild(random, 1e-2);
  if (random.chance(0.1)) {
    tick.finite = false;
    double* const places[] = {&in.dt_s,
                              &in.hold_s,
                              &in.gain,
                              &in.budget,
                              &in.F_H_D.f[static_cast<Eigen::Index>(random.below(3))],
                              &in.F_H_D.t[static_cast<Eigen::Index>(random.below(3))],
                              &in.V_DH_D.v[static_cast<Eigen::Index>(random.below(3))],
                              &in.V_DH_D.w[static_cast<Eigen::Index>(random.below(3))],
                              &in.displacement_D.v[static_cast<Eigen::Index>(random.below(3))],
                              &in.displacement_D.w[static_cast<Eigen::Index>(random.below(3))]};
    *places[random.below(std::size(places))] = no_number(random);
  }
  return tick;
}

SafetyLimits hot_limits() {
  SafetyLimits limits;
  limits.continuous_force = 8.0;
  limits.continuous_torque = 0.2;
  return limits;
}

/// Runs the full count of hostile ticks; `holds(tick, output, previous output)` must be true in
/// each.
template <typename Law>
void run_hostile(std::uint64_t seed, const Law& holds) {
  SplitMix64 random(seed);
  const SafetyLimits limits = hot_limits();
  SafetyState state;
  SafetyOutput previous;
  std::int64_t written = 0;
  const std::int64_t count = scaled(10'000'000);
  for (std::int64_t i = 0; i < count; ++i) {
    const HostileTick tick = hostile_tick(random, i * 1'000'000);
    const SafetyOutput output = limit(tick.input, limits, state);
    if (!holds(tick, output, previous)) FAIL("the law is broken in tick " << i);
    if (to_vector(output.f_H_D).norm() > 0.0) ++written;
    previous = output;
  }
  CHECK(written > count / 4);  // the law was not kept by silence
}

/// Distance of `out` from the segment between 0 and `previous`, by bisection, in long double.
long double growth(const Array3& out, const Array3& previous) {
  const Long3 F = to_long(out);
  const Long3 F_prev = to_long(previous);
  long double low = 0.0L;
  long double high = 1.0L;
  for (int k = 0; k < 70; ++k) {
    const long double middle = (low + high) / 2.0L;
    if ((middle * F_prev - F).dot(F_prev) < 0.0L) {
      low = middle;
    } else {
      high = middle;
    }
  }
  return (F - low * F_prev).norm();
}

/// Ticks until a constant wrench is reached, with the handle at rest.
SafetyOutput settle(const Wrench& F, const SafetyLimits& limits, SafetyState& state, int ticks) {
  SafetyInput input;
  input.dt_s = 1e-3;
  input.enable = true;
  input.gain = 1.0;
  input.F_H_D = F;
  SafetyOutput output;
  for (int k = 0; k < ticks; ++k) output = limit(input, limits, state);
  return output;
}

/// A port that never limits: for tests of the other guards alone.
SafetyLimits without_port() {
  SafetyLimits limits;
  limits.passivity.allowance = 1e9;
  return limits;
}

}  // namespace

TEST_CASE("whatever comes in, what is written is finite") {
  run_hostile(1, [](const HostileTick&, const SafetyOutput& out, const SafetyOutput&) {
    return to_vector(out.f_H_D).allFinite() && to_vector(out.t_H_D).allFinite();
  });
}

TEST_CASE("whatever comes in, force and torque stay within the peak") {
  run_hostile(2, [](const HostileTick&, const SafetyOutput& out, const SafetyOutput&) {
    return to_long(out.f_H_D).norm() <= 22.0L * (1 + 1e-15L) &&
           to_long(out.t_H_D).norm() <= 0.515L * (1 + 1e-15L);
  });
}

TEST_CASE("whatever comes in, force and torque grow no faster than the slew") {
  run_hostile(3,
              [](const HostileTick& tick, const SafetyOutput& out, const SafetyOutput& previous) {
                // Where the time is none the output is zero, which never grows.
                const double dt_s =
                    std::isfinite(tick.input.dt_s) ? std::clamp(tick.input.dt_s, 0.0, 0.005) : 0.0;
                return growth(out.f_H_D, previous.f_H_D) <= 2200.0L * dt_s + 1e-12L &&
                       growth(out.t_H_D, previous.t_H_D) <= 50.0L * dt_s + 1e-13L;
              });
}

TEST_CASE("nothing is written while disabled, or when any input is no number, and that is said") {
  run_hostile(4, [](const HostileTick& tick, const SafetyOutput& out, const SafetyOutput&) {
    const bool silent = out.f_H_D == Array3{} && out.t_H_D == Array3{} && !out.enable &&
                        out.expires_ns <= tick.input.now_ns;
    if (!tick.finite) return silent && out.flags == kSafetyNotFinite;
    if (!tick.input.enable) return silent && out.flags == 0;
    return out.enable;
  });
}

TEST_CASE("every command expires after its time to live, at the end of time too") {
  run_hostile(5, [](const HostileTick& tick, const SafetyOutput& out, const SafetyOutput&) {
    if (!out.enable) return true;
    const std::int64_t end = std::numeric_limits<std::int64_t>::max();
    const std::int64_t now = tick.input.now_ns;
    return out.expires_ns == (now > end - 5'000'000 ? end : now + 5'000'000);
  });
}

TEST_CASE("a limit that is no number, or negative, silences the device") {
  SafetyLimits good;
  double* const places[] = {&good.peak.force,
                            &good.peak.torque,
                            &good.continuous_force,
                            &good.continuous_torque,
                            &good.thermal_window_s,
                            &good.passivity.allowance,
                            &good.passivity.soft_share,
                            &good.passivity.credit,
                            &good.passivity.acceleration,
                            &good.passivity.angular_acceleration,
                            &good.passivity.damping,
                            &good.passivity.rotational_damping};
  const Wrench push{{1, 0, 0}, {0, 0.01, 0}};
  for (double* place : places) {
    const double kept = *place;
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), -1.0}) {
      *place = bad;
      SafetyState state;
      const SafetyOutput out = settle(push, good, state, 3);
      CHECK(out.f_H_D == Array3{});
      CHECK(out.flags == kSafetyNotFinite);
    }
    *place = kept;
  }
  SafetyState state;
  CHECK(settle(push, good, state, 3).f_H_D[0] == doctest::Approx(1.0));
}

TEST_CASE("a wrench in reach passes unchanged, and says that nothing was done") {
  SplitMix64 random(6);
  const SafetyLimits limits = without_port();
  for (std::int64_t i = 0; i < scaled(100'000); ++i) {
    SafetyState state;
    const Wrench F{to_vector(random.direction()) * random.uniform(0.0, 2.19),
                   to_vector(random.direction()) * random.uniform(0.0, 0.0499)};
    const SafetyOutput out = settle(F, limits, state, 1);
    REQUIRE((to_vector(out.f_H_D) - F.f).norm() <= 1e-15);
    REQUIRE((to_vector(out.t_H_D) - F.t).norm() <= 1e-16);
    REQUIRE(out.flags == 0);
  }
}

TEST_CASE("a wrench within its limits is written with the bits it came with") {
  SplitMix64 random(fresh_seed());
  std::int64_t untouched = 0;
  for (std::int64_t i = 0; i < scaled(200'000); ++i) {
    SafetyLimits limits = random.chance(0.5) ? SafetyLimits{} : hot_limits();
    SafetyState state;
    SafetyInput input;
    input.dt_s = 1e-3;
    input.enable = true;
    input.gain = 1.0;
    // From a millionth of a newton to all that may come in one tick.
    const double size = std::pow(10.0, random.uniform(-6.0, 0.3));
    input.F_H_D = {size * to_vector(random.direction()), 0.02 * to_vector(random.direction())};
    if (random.chance(0.2)) input.F_H_D.f[static_cast<Eigen::Index>(random.below(3))] = -0.0;
    // The hand gives way to nothing: it pushes in.
    input.V_DH_D.v = -0.1 * input.F_H_D.f;
    for (int tick = 0; tick < 3; ++tick) {
      const SafetyOutput out = limit(input, limits, state);
      if (out.flags != 0) continue;
      ++untouched;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto axis = static_cast<Eigen::Index>(k);
        REQUIRE(std::bit_cast<std::uint64_t>(out.f_H_D[k]) ==
                std::bit_cast<std::uint64_t>(input.F_H_D.f[axis]));
        REQUIRE(std::bit_cast<std::uint64_t>(out.t_H_D[k]) ==
                std::bit_cast<std::uint64_t>(input.F_H_D.t[axis]));
      }
    }
  }
  CHECK(untouched > scaled(200'000));
}

TEST_CASE("what was given before the motors went off is still owed when they are on again") {
  SplitMix64 random(fresh_seed());
  for (std::int64_t i = 0; i < scaled(30); ++i) {
    SafetyLimits limits = without_port();
    limits.passivity = {};
    limits.passivity.damping = limits.passivity.rotational_damping = 0.0;
    SafetyState state;
    SafetyInput input;
    input.dt_s = 1e-3;
    input.gain = 1.0;
    const double speed = random.uniform(0.05, 1.0);
    input.V_DH_D.v = {speed, 0, 0};
    input.F_H_D.f = {10, 0, 0};
    double given = 0.0;
    // A minute of 10 N along a hand that goes on and on, switched off and on again.
    for (int tick = 0; tick < 60'000; ++tick) {
      input.enable = !random.chance(0.05);
      input.displacement_D.v = {speed * 1e-3, 0, 0};
      given += limit(input, limits, state).f_H_D[0] * speed * 1e-3;
    }
    CHECK(given <= 4e-3 + 60.0 * kForgivenPower);
    CHECK(given >= 3e-3);
  }
}

TEST_CASE("a wrench beyond the peak is written in its own direction") {
  SplitMix64 random(7);
  const SafetyLimits limits = without_port();
  for (std::int64_t i = 0; i < scaled(100'000); ++i) {
    SafetyState state;
    const double size = std::pow(10.0, random.uniform(1.5, 300.0));
    const Wrench F{to_vector(random.direction()) * size, to_vector(random.direction()) * size};
    const SafetyOutput out = settle(F, limits, state, 12);
    REQUIRE(to_vector(out.f_H_D).norm() == doctest::Approx(22.0));
    REQUIRE(to_vector(out.t_H_D).norm() == doctest::Approx(0.515));
    REQUIRE(to_vector(out.f_H_D).normalized().dot(F.f.stableNormalized()) > 1 - 1e-9);
    REQUIRE(to_vector(out.t_H_D).normalized().dot(F.t.stableNormalized()) > 1 - 1e-9);
    REQUIRE((out.flags & kSafetySaturated) != 0);
  }
}

TEST_CASE("a force that falls, ends or is shortened by the ramp is written so in the same tick") {
  SplitMix64 random(8);
  const SafetyLimits limits = without_port();
  for (std::int64_t i = 0; i < scaled(20'000); ++i) {
    SafetyState state;
    const Vector3 direction = to_vector(random.direction());
    settle({direction * 20.0, direction * 0.5}, limits, state, 12);
    const double share = random.chance(0.2) ? 0.0 : random.uniform();
    SafetyInput input;
    input.dt_s = 0.0;  // no time for growth at all
    input.enable = true;
    input.gain = share;
    input.F_H_D = {direction * 20.0, direction * 0.5};
    const SafetyOutput out = limit(input, limits, state);
    REQUIRE((to_vector(out.f_H_D) - direction * (20.0 * share)).norm() <= 1e-13);
    REQUIRE((to_vector(out.t_H_D) - direction * (0.5 * share)).norm() <= 1e-14);
  }
}

TEST_CASE("a force that turns round falls to zero at once and then grows by the slew") {
  SafetyState state;
  const SafetyLimits limits = without_port();
  settle({{20, 0, 0}, {0, 0, 0}}, limits, state, 12);
  for (int k = 1; k <= 9; ++k) {
    const SafetyOutput out = settle({{-20, 0, 0}, {0, 0, 0}}, limits, state, 1);
    CHECK(out.f_H_D[0] == doctest::Approx(-2.2 * k));
  }
}

TEST_CASE("a pause does not become a jump: growth is that of 5 ms at most") {
  SafetyState state;
  SafetyInput input;
  input.dt_s = 10.0;
  input.enable = true;
  input.gain = 1.0;
  input.F_H_D.f = {22, 0, 0};
  CHECK(limit(input, without_port(), state).f_H_D[0] == doctest::Approx(11.0));
}

TEST_CASE("a gain above 1 counts as 1, one below 0 as 0") {
  for (const double gain : {2.0, 1.0, -1.0}) {
    SafetyState state;
    SafetyInput input;
    input.dt_s = 1e-3;
    input.enable = true;
    input.gain = gain;
    input.F_H_D = {{1, 0, 0}, {0, 0, 0.01}};
    const SafetyOutput out = limit(input, without_port(), state);
    CHECK(out.f_H_D[0] == doctest::Approx(gain > 0 ? 1.0 : 0.0));
    CHECK(out.t_H_D[2] == doctest::Approx(gain > 0 ? 0.01 : 0.0));
  }
}

TEST_CASE("as the reserve goes, what points along the motion goes with it, and alone") {
  for (const auto& each : {std::pair{2e-3, 0.1}, std::pair{3e-3, 0.05}, std::pair{3.8e-3, 0.0}}) {
    const double given = each.first;
    const double along = each.second;
    CAPTURE(given);
    SafetyState state;
    state.port.given = given;
    SafetyInput input;
    input.dt_s = 1e-3;
    input.enable = true;
    input.gain = 1.0;
    input.F_H_D.f = {0.1, 0.1, 0};
    input.V_DH_D.v = {0.1, 0, 0};
    const SafetyOutput out = limit(input, SafetyLimits{}, state);
    // The slow fade has begun, too: by 0.48 % in this tick.
    CHECK(out.f_H_D[0] == doctest::Approx(along * 0.9952));
    CHECK(out.f_H_D[1] == doctest::Approx(0.09952));
    CHECK((out.flags & kSafetyPassivity) != 0);
  }
}

TEST_CASE("what a simulated hand feels of a slow fade follows the gain tick by tick") {
  SafetyState state;
  SafetyInput input;
  input.dt_s = 1e-3;
  input.enable = true;
  input.F_H_D.f = {0, 10, 0};
  for (int k = 0; k <= 200; ++k) {
    input.gain = k / 200.0;
    CHECK(limit(input, without_port(), state).f_H_D[1] == doctest::Approx(10.0 * k / 200.0));
  }
}

}  // namespace hapticd::test
