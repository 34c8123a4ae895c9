// Truth: the energy integral on the hand's side, in long double: what the hand felt, up to three
// ticks after it was written, over what the hand moved. The hands search for their worst: they push
// on with what they feel, turn, hesitate, at speeds and in worlds drawn anew in each run. A tick
// that is late holds its wrench for longer than was reckoned with: what the hand draws in it, and
// from what was on its way then, no limit foresees.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>

#include "core/safety/output_stage.h"
#include "core/safety/passivity.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr double kTick_s = 1e-3;
constexpr int kMinute = 60'000;

/// A hand that wants energy, and what pushes it.
struct Adversary {
  explicit Adversary(SplitMix64& random_in)
      : top(random_in.uniform(0.1, 3.0)),
        peak(random_in.chance(0.5) ? random_in.uniform(0.5, 3.0) : random_in.uniform(3.0, 22.0)),
        negative_damping(random_in.chance(0.5) ? random_in.uniform(0.0, 100.0) : 0.0),
        hesitates(random_in.uniform(0.0, 0.5)),
        late(random_in.chance(0.5) ? 1e-3 : 0.0),
        engages_anew(random_in.chance(0.5) ? 1e-3 : 0.0),
        to_and_fro(random_in.chance(0.3)),
        random(random_in) {}

  double top;               ///< speed, m/s
  double peak;              ///< N
  double negative_damping;  ///< of the world, N s/m
  double hesitates;         ///< share of ticks
  double late;              ///< share of ticks
  double engages_anew;      ///< share of ticks
  bool to_and_fro;          ///< and pushed along its motion
  SplitMix64& random;

  Vector3 world = Vector3::Zero();
  double way = 1.0;
  double x = 0.0;

  Vector3 pushes(const Vector3& v) {
    if (to_and_fro) return {way * peak, 0.0, 0.0};
    if (random.chance(0.005)) {
      world = to_vector(random.direction()) * random.uniform(0.0, 2 * peak);
    }
    return world + negative_damping * v;
  }

  /// Velocity that it would like.
  Vector3 wants(const Vector3& felt) {
    if (to_and_fro) {
      if (std::abs(x) > 0.1) way = x > 0.0 ? -1.0 : 1.0;
      return {way * top, 0.0, 0.0};
    }
    Vector3 wanted = felt.norm() > 0.0 ? Vector3(felt.normalized() * top)
                                       : Vector3(to_vector(random.direction()) * top);
    return random.chance(hesitates) ? Vector3(-0.2 * wanted) : wanted;
  }
};

/// What a hand has drawn at most in a minute, J.
struct Drawn {
  double in_time = 0.0;  ///< but in late ticks and as many ticks after each as the wrench is late
  double all = 0.0;
};

/// Of a wrench that comes `delay` ticks late where up to `flight` are reckoned with.
Drawn drawn(Adversary hand, int delay, int flight) {
  SafetyLimits limits;
  limits.peak = {hand.peak, 0.1};
  limits.passivity.damping = limits.passivity.rotational_damping = 0.0;
  SafetyState state;
  SafetyInput input;
  input.gain = 1.0;
  input.enable = true;
  input.flight = flight;
  std::array<Vector3, kMostFlight + 1> sent;
  sent.fill(Vector3::Zero());
  Vector3 v = Vector3::Zero();
  Vector3 moved = Vector3::Zero();
  long double given = 0.0L;
  long double in_time = 0.0L;
  Drawn most;
  double dt_s = kTick_s;
  int unforeseen = 0;  // ticks that a late one still has a part in
  for (int i = 0; i < kMinute; ++i) {
    if (hand.random.chance(hand.engages_anew)) input.enable = false;
    if (hand.random.chance(0.05)) input.enable = true;
    input.dt_s = dt_s;
    input.now_ns += static_cast<std::int64_t>(dt_s * 1e9);
    input.V_DH_D.v = moved / dt_s;
    input.displacement_D.v = moved;
    input.F_H_D.f = hand.pushes(v);
    const SafetyOutput out = limit(input, limits, state);
    std::copy_backward(sent.begin(), sent.end() - 1, sent.end());
    sent[0] = to_vector(out.f_H_D);
    const Vector3& felt = sent[static_cast<std::size_t>(delay)];
    dt_s = hand.random.chance(hand.late) ? kTick_s * static_cast<double>(1 + hand.random.below(4))
                                         : kTick_s;
    Vector3 change = hand.wants(felt) - v;
    const double can = limits.passivity.acceleration * dt_s;
    if (change.norm() > can) change *= can / change.norm();
    moved = (v + 0.5 * change) * dt_s;
    v += change;
    hand.x += moved.x();
    const long double gives = felt.cast<long double>().dot(moved.cast<long double>());
    unforeseen = dt_s > kTick_s ? delay + 1 : std::max(0, unforeseen - 1);
    given += gives;
    if (unforeseen == 0 || gives < 0.0L) in_time += gives;
    most.all = std::max(most.all, static_cast<double>(given));
    most.in_time = std::max(most.in_time, static_cast<double>(in_time));
  }
  return most;
}

}  // namespace

TEST_CASE(
    "no hand draws more than 5 mJ in a minute, however late its wrench is, but in ticks that are "
    "late themselves") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int trial = 0; trial < static_cast<int>(scaled(1000)); ++trial) {
    const Adversary hand(random);
    const int delay = static_cast<int>(random.below(kMostFlight + 1));
    CAPTURE(trial);
    CAPTURE(delay);
    const Drawn most = drawn(hand, delay, kMostFlight);
    REQUIRE(most.in_time <= 5e-3);
    if (hand.late == 0.0) REQUIRE(most.all <= 5e-3);
    // A tick that is held four times as long gives four times what was left at most.
    REQUIRE(most.all <= 4 * 4e-3 + 5e-3);
  }
}

TEST_CASE("a hand whose wrench is later than was reckoned with draws more") {
  SplitMix64 random(fresh_seed());
  double most = 0.0;
  for (int trial = 0; trial < 20; ++trial) {
    most = std::max(most, drawn(Adversary(random), kMostFlight, 0).all);
  }
  CHECK(most > 10e-3);
}

TEST_CASE("a spring that any device bears is felt whole, however late its wrench may be") {
  // Pressed to the peak and let go, at 200 N/m, 10 mm/s and less.
  const double stiffness = 200.0;
  SafetyLimits limits;
  limits.passivity.damping = 0.0;
  SafetyState state;
  SafetyInput input;
  input.dt_s = kTick_s;
  input.enable = true;
  input.gain = 1.0;
  input.flight = kMostFlight;
  double before = 0.0;
  for (int i = 1; i < 20'000; ++i) {
    const double x = -0.01 * (1 - std::cos(1e-3 * i)) / 2;
    input.displacement_D.v = {x - before, 0, 0};
    input.V_DH_D.v = input.displacement_D.v / kTick_s;
    input.F_H_D.f = {-stiffness * x, 0, 0};
    before = x;
    const SafetyOutput out = limit(input, limits, state);
    REQUIRE(std::abs(out.f_H_D[0] - input.F_H_D.f.x()) <= 1e-12);
  }
}

}  // namespace hapticd::test
