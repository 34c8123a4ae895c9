// What a ringing string gives to the hand: never more than it had, and never a pull.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "tests/core/instrument/string_hand.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kTurn = 2.0 * 3.14159265358979323846;

/// A hand that swings in and out with the string's own frequency.
struct Adversary {
  double frequency;  ///< Hz
  double amplitude;  ///< A, m
  double depth;      ///< D0, m: its middle within the string
  double phase;      ///< turns

  [[nodiscard]] double distance(double t) const {
    return -depth - amplitude * std::sin(kTurn * (frequency * t + phase));
  }
  [[nodiscard]] double acceleration() const {
    return amplitude * (kTurn * frequency) * (kTurn * frequency);
  }
};

/// How long the adversary takes from where the pluck left the hand into its swing, ticks. A hand
/// that was put there at once would be faster than the tank is told hands can be.
constexpr int kApproach = 40;
/// The most that adds to the acceleration, m/s^2.
constexpr double kApproachAcceleration = 200.0;

/// A plucked string and the energy it rings with, the tool far away.
StringHand plucked_string(double frequency, double max_acceleration, double touch_decay = 0.03) {
  StringHand hand;
  hand.string = sounding_string(frequency);
  hand.string.touch_decay = touch_decay;
  hand.lambda = 0.4;
  hand.options.max_acceleration = max_acceleration;
  pluck(hand, 4e-3);
  return hand;
}

/// Largest work that F_v ever did on the adversary's hand, over the largest energy that the string
/// was released with so far, at once and once more per 100 ms: the adversary may pluck it anew in
/// every swing.
double most_drawn(StringHand hand, const Adversary& adversary, int ticks) {
  double drawn = 0.0;
  double most = 0.0;
  double released = hand.state.vibration.released_energy;
  const double away = hand.distance - adversary.distance(0.0);
  for (int k = 0; k < ticks; ++k) {
    const double before = hand.distance;
    const double held = hand.response.vibration_force;
    const double left = k < kApproach
                            ? 0.5 + 0.5 * std::cos(0.5 * kTurn * static_cast<double>(k) / kApproach)
                            : 0.0;
    move_to(hand, adversary.distance(static_cast<double>(k) * 1e-3) + left * away);
    drawn += held * (hand.distance - before);
    most = std::max(most, drawn / (released * (1.0 + static_cast<double>(k) / 100.0)));
    released = std::max(released, hand.state.vibration.released_energy);
  }
  return most;
}

/// The same work of Eq. 9 rendered as it stands, with the same static force beside it, J.
double most_drawn_without_tank(const StringHand& plucked, const Adversary& adversary, int ticks) {
  StringHand hand = plucked;
  const double r = hand.state.vibration.amplitude;
  double drawn = 0.0;
  double most = 0.0;
  double held = 0.0;
  for (int k = 0; k < ticks; ++k) {
    const double t = static_cast<double>(k) * 1e-3;
    const double before = hand.distance;
    hand.distance = adversary.distance(t);
    drawn += held * (hand.distance - before);
    most = std::max(most, drawn);
    const double pressed = std::max(-hand.distance, 0.0);
    const double still = deflect_in_series(hand.string, hand.lambda, pressed, 1000.0).force;
    const double a = r * std::exp(-t / 0.5) * std::sin(kTurn * adversary.frequency * t);
    held =
        pressed > 0.0 ? std::max(vibration_stiffness(hand.string, hand.lambda) * a, -still) : 0.0;
  }
  return most;
}

constexpr std::array kAmplitudes = {1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2};

/// Runs every amplitude, phase and depth of the adversary against a string plucked once; the most
/// that any of them drew, over E0.
double worst_share() {
  SplitMix64 random(41);
  double worst = 0.0;
  const std::int64_t phases = scaled(64);
  for (const double frequency : {65.4, 98.0, 146.8}) {
    for (const double amplitude : kAmplitudes) {
      Adversary adversary{frequency, amplitude, 0.0, 0.0};
      const double limit = std::max(500.0, 1.05 * adversary.acceleration() + kApproachAcceleration);
      // A finger that damps, and one that lets the string ring on.
      for (const double touch_decay : {0.03, 0.5}) {
        const StringHand hand = plucked_string(frequency, limit, touch_decay);
        REQUIRE(hand.state.vibration.released_energy > 1e-4);
        for (std::int64_t i = 0; i < phases; ++i) {
          adversary.phase = random.uniform();
          adversary.depth = random.uniform(-1.0, 2.0) * amplitude;
          worst = std::max(worst, most_drawn(hand, adversary, 600));
        }
      }
    }
  }
  return worst;
}

TEST_CASE(
    "no hand that swings with the fundamental gets more than E0 and E0 per 100 ms out of it") {
  CHECK(worst_share() <= 1.0);
}

TEST_CASE("without a tank such a hand gets many times E0") {
  const StringHand hand = plucked_string(98.0, 500.0);
  const double E0 = hand.state.vibration.released_energy;
  double without = 0.0;
  double with = 0.0;
  for (int i = 0; i < 64; ++i) {
    const Adversary adversary{98.0, 1e-3, 2e-3, i / 64.0};
    without = std::max(without, most_drawn_without_tank(hand, adversary, 1000));
    with = std::max(with, most_drawn(hand, adversary, 1000));
  }
  CHECK(without > 10.0 * E0);
  CHECK(with <= 1.001);
  // The tank does not win by giving nothing.
  CHECK(with > 0.1);
}

TEST_CASE("static and vibration force together never attract, and all stays finite") {
  SplitMix64 random(42);
  const std::int64_t runs = scaled(400);
  std::int64_t ticks_with_force = 0;
  for (std::int64_t run = 0; run < runs; ++run) {
    StringHand hand;
    hand.string = sounding_string(random.uniform(60.0, 600.0));
    hand.lambda = random.chance(0.1) ? std::round(random.uniform()) : random.uniform();
    hand.options.pitch_glide = random.chance(0.5);
    pluck(hand, random.uniform(0.5e-3, 8e-3));
    for (int k = 0; k < 200; ++k) {
      const double reach = random.chance(0.1) ? 1e-2 : 1e-3;
      const double next = hand.distance > 0.01 ? 3e-3 : hand.distance;
      move_to(hand, std::clamp(next + random.uniform(-reach, reach), -2e-2, 2e-2),
              static_cast<std::int64_t>(random.uniform(0.0, 5e6)));
      const double force = hand.response.vibration_force;
      REQUIRE(std::isfinite(force));
      REQUIRE(std::isfinite(hand.state.vibration.energy));
      REQUIRE(hand.touch.force + force >= 0.0);
      REQUIRE(hand.state.tank.energy <= hand.state.tank.full);
      ticks_with_force += force != 0.0 ? 1 : 0;
    }
  }
  CHECK(ticks_with_force > runs);
}

TEST_CASE("the vibration follows Eq. 9 whatever it gives, and the tank has what it has not given") {
  StringHand hand = plucked_string(98.0, 500.0);
  hand.string.touch_decay = 1e12;
  hand.string.decay = 1e12;
  double most = 0.0;
  double left = hand.state.tank.full;
  const double full = left;
  const double start = hand.state.vibration.energy;
  for (int k = 0; k < 300; ++k) {
    const double before = hand.distance;
    const double held = hand.response.vibration_force;
    move_to(hand, -3e-3 - 1e-3 * std::sin(kTurn * 98.0 * k * 1e-3));
    left = std::min(left - held * (hand.distance - before), full);
    most = std::max(most, full - left);
    CHECK(hand.state.vibration.energy == within(start, 1e-9));
    CHECK(hand.state.tank.energy == within(left, 1e-6));
  }
  CHECK(most > 0.1 * full);
}

TEST_CASE("the jump of a distance, as the tool slips off, pays nothing into the tank") {
  StringHand hand = plucked_string(98.0, 500.0);
  hand.distance = 5e-3;
  // Lightly, so that it is not armed; until the string swings away from the finger.
  while (hand.response.vibration_force >= 0.0) move_to(hand, -0.2e-3);
  REQUIRE(hand.state.level == StringPhase::kFundamental);
  hand.state.tank.energy *= 0.5;
  const double in_tank = hand.state.tank.energy;
  move_to(hand, 5e-3);
  REQUIRE(count_events(hand, StringEventKind::kLeave) == 1);
  REQUIRE(hand.state.level == StringPhase::kFundamental);
  CHECK(hand.state.tank.energy <= in_tank);
}

TEST_CASE("as a ringing string falls still under a finger, the static force alone remains") {
  StringHand hand = plucked_string(98.0, 1e-3);
  hand.options.sleep_energy = 1e-12;
  glide_to(hand, -8e-3, 20);
  for (int i = 0; i < 150; ++i) move_to(hand, -8e-3);
  REQUIRE(hand.state.level != StringPhase::kStatic);
  REQUIRE(hand.touch.force > 0.5);
  // Five decay times: exp(-5) of what was at most k_v r, half a newton.
  CHECK(std::abs(hand.response.vibration_force) < 5e-3);
}

TEST_CASE("a release fills the tank with what bends the string, by its share of 100 ms") {
  StringHand hand;
  hand.string = sounding_string(98.0);
  const auto pluck_by_withdrawing = [&] {
    glide_to(hand, -5e-3, 40);
    const double deflection = hand.touch.deflection;
    glide_to(hand, 3e-3, 4);
    return 0.5 * vibration_stiffness(hand.string, 0.5) * deflection * deflection;
  };
  const double full = pluck_by_withdrawing();
  CHECK(hand.state.tank.energy == within(full, 1e-9));
  hand.state.tank.energy = 0.0;
  pluck_by_withdrawing();
  // 44 ms later; what the press gave back is in it too.
  CHECK(hand.state.tank.energy > 0.3 * full);
  CHECK(hand.state.tank.energy <= full * (1.0 + 1e-9));
}

}  // namespace
}  // namespace hapticd::test
