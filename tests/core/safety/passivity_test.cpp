// Truth: the energy integral of what was written over what was moved, in long double, for hands
// that do the worst they can within the accelerations of the profile; and hands and worlds in
// closed form that must not be touched.
#include "core/safety/passivity.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/safety/output_stage.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr double kTick_s = 1e-3;

/// How the adversary moves: toward what it was just given, against it, or at random.
enum class Hand { kGreedy, kFlipping, kRandom };

/// Next displacement within the acceleration limit of V (m or rad per tick), at most `top` per s.
Vector3 move(Hand hand, const Vector3& V, const Vector3& pull, double acceleration, double top,
             std::uint64_t tick, SplitMix64& random) {
  Vector3 u = to_vector(random.direction());
  if (hand == Hand::kGreedy && pull.norm() > 0.0) u = pull.normalized();
  if (hand == Hand::kFlipping && pull.norm() > 0.0) {
    u = tick % 2 == 0 ? pull.normalized() : Vector3(-V / std::max(1e-9, V.norm()));
  }
  // A hand at its top speed can only slow down.
  if ((V + u * acceleration * kTick_s).norm() > top) u = -V / std::max(1e-9, V.norm());
  return V * kTick_s + u * (acceleration * kTick_s * kTick_s * (1 - 1e-9));
}

struct Ledger {
  long double given = 0.0L;    ///< to the hand
  long double repaid = 0.0L;   ///< by the damping of the device, at least, or forgiven
  long double budgets = 0.0L;  ///< first budget and every rise of it
  long double worst = -1e9L;   ///< largest given - repaid - budgets
};

/// `ticks` of an adversary against a world that pushes along its motion as hard as it can.
Ledger play_adversary(std::uint64_t seed, double damping, bool budgets, std::int64_t ticks) {
  SplitMix64 random(seed);
  SafetyLimits limits;
  limits.passivity.damping = damping;
  limits.passivity.rotational_damping = damping * 1e-3;
  SafetyState state;
  SafetyInput input;
  input.dt_s = kTick_s;
  input.enable = true;
  input.gain = 1.0;
  Ledger ledger;
  Hand hand = Hand::kGreedy;
  Vector3 world = Vector3::Zero();
  for (std::int64_t i = 0; i < ticks; ++i) {
    if (random.chance(0.002)) hand = static_cast<Hand>(random.below(3));
    if (random.chance(0.01)) world = to_vector(random.direction()) * random.uniform(0.0, 30.0);
    if (budgets) {
      const double budget = random.chance(0.01) ? random.uniform(0.0, 5e-3) : input.budget * 0.99;
      ledger.budgets += std::max(0.0, budget - input.budget);
      input.budget = budget;
    }
    const Vector3& V = input.V_DH_D.v;
    input.F_H_D.f = random.chance(0.5) ? Vector3(world + 50.0 * V) : world;
    input.F_H_D.t = to_vector(random.direction()) * random.uniform() + input.V_DH_D.w;
    const SafetyOutput out = limit(input, limits, state);
    const Vector3 f = to_vector(out.f_H_D);
    const Vector3 t = to_vector(out.t_H_D);
    const auto tick = static_cast<std::uint64_t>(i);
    const Vector3 dx = move(hand, V, f, limits.passivity.acceleration, 3.0, tick, random);
    const Vector3 turn =
        move(hand, input.V_DH_D.w, t, limits.passivity.angular_acceleration, 20.0, tick, random);
    ledger.given += f.cast<long double>().dot(dx.cast<long double>()) +
                    t.cast<long double>().dot(turn.cast<long double>());
    ledger.repaid += damping * (dx.squaredNorm() + 1e-3 * turn.squaredNorm()) / kTick_s;
    ledger.repaid += kForgivenPower * kTick_s;
    ledger.worst = std::max(ledger.worst, ledger.given - ledger.repaid - ledger.budgets);
    input.displacement_D = {dx, turn};
    input.V_DH_D = {dx / kTick_s, turn / kTick_s};
  }
  return ledger;
}

/// A handle of `mass` without a hand, thrown at a wall of stiffness K that answers `delay` ticks
/// late; the largest kinetic energy afterwards relative to that at the start.
double bounce(double stiffness, int delay, double damping, const SafetyLimits& limits) {
  constexpr double kMass = 0.15;
  SafetyState state;
  SafetyInput input;
  input.dt_s = kTick_s;
  input.enable = true;
  input.gain = 1.0;
  double x = 0.0;
  double v = -0.3;
  std::array<double, 8> late{};
  double largest = 0.0;
  for (int i = 0; i < 4000; ++i) {
    late[static_cast<std::size_t>(i) % late.size()] = x;
    const double seen = late[static_cast<std::size_t>(i + 8 - delay) % late.size()];
    // A cage: walls on both sides, 5 mm apart, so that contact never ends.
    input.F_H_D.f = {-stiffness * (seen - std::clamp(seen, -0.0025, 0.0025)), 0, 0};
    const SafetyOutput out = limit(input, limits, state);
    const double before = x;
    for (int k = 0; k < 100; ++k) {
      v += (out.f_H_D[0] - damping * v) / kMass * kTick_s / 100;
      x += v * kTick_s / 100;
    }
    input.displacement_D.v = {x - before, 0, 0};
    input.V_DH_D.v = {(x - before) / kTick_s, 0, 0};
    if (i > 2000) largest = std::max(largest, v * v / 0.09);
  }
  return largest;
}

/// Flags and largest difference between what a spring asks for and what is written, while the
/// handle follows `x(tick)` into a wall of `stiffness` below x = 0.
template <typename Way>
double largest_change(double stiffness, int ticks, const Way& x) {
  SafetyLimits limits;
  SafetyState state;
  SafetyInput input;
  input.dt_s = kTick_s;
  input.enable = true;
  input.gain = 1.0;
  double largest = 0.0;
  for (int i = 1; i < ticks; ++i) {
    input.displacement_D.v = {x(i) - x(i - 1), 0, 0};
    input.V_DH_D.v = input.displacement_D.v / kTick_s;
    input.F_H_D.f = {stiffness * std::max(0.0, -x(i)), 0, 0};
    const SafetyOutput out = limit(input, limits, state);
    if ((out.flags & kSafetySlew) == 0) {
      largest = std::max(largest, std::abs(out.f_H_D[0] - input.F_H_D.f.x()));
    }
  }
  return largest;
}

}  // namespace

TEST_CASE("no adversary draws more than the allowance where nothing repays it") {
  for (const std::uint64_t seed : {31U, 32U, 33U}) {
    const Ledger ledger = play_adversary(seed, 0.0, false, scaled(3'000'000));
    CHECK(ledger.worst <= 4e-3L * (1 + 1e-9L));
    CHECK(ledger.worst > 2e-3L);  // it does reach for it
  }
}

TEST_CASE("the device's own damping repays, and no more is given than that and the allowance") {
  const Ledger ledger = play_adversary(34, 1.0, false, scaled(3'000'000));
  CHECK(ledger.worst <= 4e-3L * (1 + 1e-9L));
}

TEST_CASE("what strings may give is given beyond the allowance, and no more") {
  for (const double damping : {0.0, 1.0}) {
    const Ledger ledger = play_adversary(35, damping, true, scaled(3'000'000));
    CHECK(ledger.worst <= 4e-3L * (1 + 1e-9L));
    CHECK(ledger.given > 4e-3L);
  }
}

TEST_CASE(
    "a wall too stiff for its delay throws a free handle about, and not with the controller") {
  SafetyLimits off;
  off.passivity.allowance = 1e9;
  CHECK(bounce(3000.0, 2, 1.0, off) > 20.0);
  const double kept = bounce(3000.0, 2, 1.0, SafetyLimits{});
  // All of the allowance in the handle: 4 mJ beside the 6.75 mJ it began with.
  CHECK(kept < 1.6);
}

TEST_CASE("a stable wall is not touched by the controller: taps at 1 m/s on 1 kN/m") {
  const auto tap = [](int i) { return 0.004 - 0.008 * std::abs(std::sin(i * kTick_s * 125.0)); };
  CHECK(largest_change(1000.0, 5000, tap) <= 1e-12);
}

TEST_CASE("a slow press to the peak and back is not touched by the controller") {
  const auto press = [](int i) { return 0.002 - 0.022 * (1 - std::cos(i * kTick_s)) / 2; };
  CHECK(largest_change(1000.0, 20'000, press) <= 1e-12);
}

TEST_CASE("a pluck is not touched: the string that slips off gives nothing back") {
  // 4 mm into 800 N/m at 0.2 m/s, then the force is gone within a tick, a hundred times over.
  SafetyLimits limits;
  SafetyState state;
  SafetyInput input;
  input.dt_s = kTick_s;
  input.enable = true;
  input.gain = 1.0;
  for (int i = 0; i < 10'000; ++i) {
    const int phase = i % 100;
    const double depth = phase < 20 ? phase * 2e-4 : 0.0;
    input.V_DH_D.v = {0, phase < 50 ? -0.2 : 0.2, 0};
    input.displacement_D.v = input.V_DH_D.v * kTick_s;
    input.F_H_D.f = {0.3 * 800.0 * depth, 800.0 * depth, 0};
    const SafetyOutput out = limit(input, limits, state);
    REQUIRE((to_vector(out.f_H_D) - input.F_H_D.f).norm() <= 1e-14);
    REQUIRE((out.flags & kSafetyPassivity) == 0);
  }
}

TEST_CASE("the soft step takes only what points along the motion") {
  PassivityLimits limits;
  PortEnergy port;
  port.given = 0.95 * limits.allowance;  // beyond the soft share
  const Wrench F{{3, 4, 0}, {0, 0, 0.1}};
  const Wrench out =
      PassivityControl(limits, 0.0, port).damped(F, {{0.2, 0, 0}, {0, 0, -1}}, kTick_s);
  CHECK(out.f.x() == doctest::Approx(0.0));
  CHECK(out.f.y() == 4.0);
  CHECK(out.t.z() == 0.1);  // it works against the turn
  CHECK(port.removed == doctest::Approx(3 * 0.2 * kTick_s));
}

TEST_CASE("a motion no hand makes leaves a debt of one allowance, and damping repays it") {
  PassivityLimits limits;
  PortEnergy port;
  limits.damping = 0.0;
  PassivityControl(limits, 0.0, port)
      .observe({{22, 0, 0}, {0, 0, 0}}, {{1e6, 0, 0}, {0, 0, 0}}, kTick_s);
  CHECK(port.given == limits.allowance);
  limits.damping = 1.0;
  // 0.2 m/s against 1 N s/m: 40 mW, 4 mJ in 0.1 s, and never credit; a little is forgiven.
  for (int i = 1; i <= 200; ++i) {
    PassivityControl(limits, 0.0, port).observe({}, {{2e-4, 0, 0}, {0, 0, 0}}, kTick_s);
    const double left = limits.allowance * std::max(0.0, 1.0 - i / 100.0);
    REQUIRE(port.given <= left + 1e-12);
    REQUIRE(port.given >= left - i * kForgivenPower * kTick_s - 1e-12);
    REQUIRE(port.given >= 0.0);
  }
}

TEST_CASE("what a string gave out of its tank is forgotten as the tank empties") {
  PassivityLimits limits;
  limits.damping = 0.0;
  PortEnergy port;
  PassivityControl(limits, 5e-3, port)
      .observe({{1, 0, 0}, {0, 0, 0}}, {{1, 0, 0}, {0, 0, 0}}, kTick_s);
  CHECK(port.given == doctest::Approx(limits.allowance + 5e-3));
  PassivityControl(limits, 2e-3, port).observe({}, {}, kTick_s);
  CHECK(port.given == doctest::Approx(limits.allowance + 2e-3));
}

TEST_CASE("credit is remembered up to what springs can store") {
  PassivityLimits limits;
  PortEnergy port;
  PassivityControl(limits, 0.0, port)
      .observe({{-10, 0, 0}, {0, 0, 0}}, {{10, 0, 0}, {0, 0, 0}}, kTick_s);
  CHECK(port.given == -limits.credit);
}

}  // namespace hapticd::test
