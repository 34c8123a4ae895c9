// What respond() does in time: force of Eq. 9, envelope, repeated releases, odd ticks.
#include "core/instrument/quasi_static_string.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <cstring>

#include "tests/core/instrument/string_hand.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

using Real = long double;

constexpr Real kPiLong = 3.14159265358979323846264338327950288L;

StringHand hand_on(double frequency) {
  StringHand hand;
  hand.string = sounding_string(frequency);
  return hand;
}

TEST_CASE(
    "whatever the speed of release and of return, the force is k_v r exp(-t / T_d) sin(omega t)") {
  SplitMix64 random(41);
  const std::int64_t runs = scaled(400);
  for (std::int64_t run = 0; run < runs; ++run) {
    StringHand hand = hand_on(random.uniform(60.0, 150.0));
    // As in the paper, the finger does not damp.
    hand.string.touch_decay = hand.string.decay = 0.5;
    hand.lambda = random.uniform(0.2, 0.8);
    const double away = std::exp(random.uniform(std::log(0.1), std::log(3.0)));
    const double back = random.uniform(0.02, 0.1);
    CAPTURE(away);
    CAPTURE(back);
    glide_to(hand, -random.uniform(2e-3, 8e-3), 200);
    const double r = hand.touch.deflection;
    while (hand.distance < 5e-3) move_to(hand, hand.distance + 1e-3 * away);
    const double t0 = 1e-9 * static_cast<double>(last_event(hand, StringEventKind::kTone).t_ns);
    const double k_v = 30.0 / (1.1 * hand.lambda * (1.0 - hand.lambda));
    double largest = 0.0;
    double worst = 0.0;
    // Down to where the static force is larger, so that nothing has to be held back lest it
    // attract.
    while (hand.distance > -15e-3) {
      move_to(hand, hand.distance - 1e-3 * back);
      const double t = 1e-9 * static_cast<double>(hand.touch.time.t_ns) - t0;
      const double truth = k_v * r * std::exp(-t / 0.5) *
                           std::sin(2.0 * static_cast<double>(kPiLong) * hand.string.frequency * t);
      if (hand.distance >= 0.0 || -truth > hand.touch.force) continue;
      largest = std::fmax(largest, std::fabs(truth));
      worst = std::fmax(worst, std::fabs(hand.response.vibration_force - truth));
    }
    CHECK(largest > 0.05);
    CHECK(worst < 0.02 * largest);
  }
}

TEST_CASE("a finger that only comes near is struck by what swings out further than its gap") {
  StringHand hand = hand_on(98.0);
  hand.string.touch_decay = hand.string.decay = 0.5;
  hand.options.max_acceleration = 1e-3;
  pluck(hand, 5e-3);
  const StringEvent tone = last_event(hand, StringEventKind::kTone);
  hand.distance = 6e-3;
  move_to(hand, 2e-3);
  move_to(hand, 2e-3);
  int struck = 0;
  int apart = 0;
  for (int i = 0; i < 100; ++i) {
    move_to(hand, 2e-3);
    const double t = static_cast<double>(hand.touch.time.t_ns - tone.t_ns) * 1e-9;
    const double a = tone.amplitude * std::exp(-t / 0.5) *
                     std::sin(2.0 * static_cast<double>(kPiLong) * 98.0 * t);
    const double truth = 4.0 * 30.0 / 1.1 * std::fmax(a - 2e-3, 0.0);
    CHECK(std::abs(hand.response.vibration_force - truth) < 1e-10);
    struck += truth > 0.0 ? 1 : 0;
    apart += truth == 0.0 ? 1 : 0;
  }
  CHECK(struck > 20);
  CHECK(apart > 20);
}

TEST_CASE("entering the envelope at 0.2 to 0.9 of its radius is a touch, and damps from then on") {
  for (const double share : {0.2, 0.4, 0.6, 0.8, 0.9}) {
    StringHand hand = hand_on(98.0);
    pluck(hand, 5e-3);
    hand.log.clear();
    // Steadily down to the given share of the envelope, from outside it.
    hand.distance = 8e-3;
    const double reach = envelope(hand.string, hand.state, 0.5, hand.touch.time.t_ns);
    const std::int64_t start_ns = hand.touch.time.t_ns;
    const double speed = 0.5;
    while (hand.distance > share * reach) move_to(hand, hand.distance - speed * 1e-3);
    REQUIRE(count_events(hand, StringEventKind::kTouch) == 1);
    const StringEvent touched = last_event(hand, StringEventKind::kTouch);
    CHECK(touched.ringing);
    CHECK(touched.normal_speed == within(speed, 1e-9));
    // The line of the tool meets the envelope, which shrinks by less than 0.3 % in a tick.
    const double t = static_cast<double>(touched.t_ns - start_ns) * 1e-9;
    const double meets = (8e-3 - reach * std::exp(-t / 0.5)) / speed;
    CHECK(t == within(meets, 1e-2));
    const StringEvent radius = last_event(hand, StringEventKind::kRadius);
    CHECK(radius.radius_phase == RadiusPhase::kDamp);
    CHECK(radius.decay == 0.03);
    CHECK(radius.t_ns == touched.t_ns);
    CHECK(radius.amplitude == within(reach * std::exp(-t / 0.5), 1e-3));
    // No work is done on a resting finger: the decay is the damped one alone.
    const double energy = hand.state.vibration.energy;
    for (int i = 0; i < 3; ++i) move_to(hand, hand.distance);
    CHECK(hand.state.vibration.energy <= energy * std::exp(-2.0 * 3e-3 / 0.03) * (1.0 + 1e-12));
    CHECK(hand.response.vibration_force >= 0.0);
    // Damped below the finger, the string is left ringing under it.
    for (int i = 0; i < 100; ++i) move_to(hand, hand.distance);
    CHECK(count_events(hand, StringEventKind::kLeave) == 1);
    CHECK(last_event(hand, StringEventKind::kRadius).radius_phase == RadiusPhase::kRelease);
    CHECK(count_events(hand, StringEventKind::kTone) == 0);
  }
}

TEST_CASE("outside the envelope nothing is touched") {
  StringHand hand = hand_on(98.0);
  pluck(hand, 5e-3);
  hand.log.clear();
  const double reach = envelope(hand.string, hand.state, 0.5, hand.touch.time.t_ns);
  hand.distance = 8e-3;
  for (int i = 0; i < 50; ++i) move_to(hand, 1.01 * reach);
  CHECK(hand.log.empty());
  CHECK(hand.response.vibration_force == 0.0);
}

TEST_CASE("five plucks give five tones, each at its own instant and place") {
  StringHand hand = hand_on(98.0);
  for (int i = 0; i < 5; ++i) {
    hand.lambda = 0.1 + 0.15 * i;
    pluck(hand, 3e-3);
    CHECK(last_event(hand, StringEventKind::kTone).lambda == hand.lambda);
    CHECK(last_event(hand, StringEventKind::kTone).t_ns ==
          last_event(hand, StringEventKind::kRelease).t_ns);
  }
  CHECK(count_events(hand, StringEventKind::kTone) == 5);
  CHECK(count_events(hand, StringEventKind::kRelease) == 5);
}

TEST_CASE("a ringing string that is pressed and released again sounds once per release") {
  StringHand hand = hand_on(98.0);
  pluck(hand, 3e-3);
  CHECK(count_events(hand, StringEventKind::kTone) == 1);
  pluck(hand, 3e-3);
  CHECK(count_events(hand, StringEventKind::kTone) == 2);
  CHECK(count_events(hand, StringEventKind::kRelease) == 2);
}

TEST_CASE("two releases within the refractory time give one tone, and the larger energy") {
  for (const bool second_is_larger : {false, true}) {
    const double first = second_is_larger ? 1e-3 : 3e-3;
    const double second = second_is_larger ? 3e-3 : 1e-3;
    StringHand hand = hand_on(98.0);
    // So that the first still rings when the second comes.
    hand.string.touch_decay = 0.5;
    glide_to(hand, -first, 300);
    for (int i = 0; i < 3000; ++i) move_to(hand, -first);
    move_to(hand, 1e-3);
    const double energy_1 = hand.state.vibration.energy;
    glide_to(hand, -second, 8);
    const double still_rings = hand.state.vibration.energy;
    CHECK(still_rings > 0.0);
    move_to(hand, 1e-3);
    CHECK(count_events(hand, StringEventKind::kRelease) == 2);
    CHECK(count_events(hand, StringEventKind::kTone) == 1);
    const double energy_2 = fundamental_energy(hand.string, hand.state.detector.largest_deflection);
    const double after = hand.state.vibration.energy;
    // The larger of the two, not their sum; a part of a tick has passed.
    const double larger = std::fmax(still_rings, energy_2);
    CHECK(after <= larger);
    CHECK(after > 0.95 * larger);
    if (second_is_larger) CHECK(after > energy_1);
  }
}

TEST_CASE("a refractory time of 0 lets every release sound") {
  StringHand hand = hand_on(98.0);
  hand.options.release.refractory = 0.0;
  for (int i = 0; i < 3; ++i) {
    move_to(hand, -2e-3);
    move_to(hand, 1e-3);
  }
  CHECK(count_events(hand, StringEventKind::kTone) == 3);
}

TEST_CASE("hovering with noise and tremor for ten seconds gives no tone") {
  SplitMix64 random(51);
  for (const double height : {0.15e-3, 0.05e-3, -0.1e-3}) {
    StringHand hand = hand_on(98.0);
    const std::int64_t ticks = scaled(10'000);
    for (std::int64_t k = 0; k < ticks; ++k) {
      const double t = static_cast<double>(k) * 1e-3;
      move_to(hand, height + 0.1e-3 * std::sin(2.0 * static_cast<double>(kPiLong) * 8.0 * t) +
                        random.uniform(-20e-6, 20e-6));
    }
    CHECK(count_events(hand, StringEventKind::kTone) == 0);
    CHECK(count_events(hand, StringEventKind::kRelease) == 0);
  }
}

TEST_CASE("one slow lift with noise gives one tone, of the largest deflection") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SplitMix64 random(60 + seed);
    StringHand hand = hand_on(98.0);
    glide_to(hand, -5e-3, 100);
    double most = hand.touch.deflection;
    const auto go = [&](double distance) {
      move_to(hand, distance + random.uniform(-20e-6, 20e-6));
      most = std::fmax(most, hand.touch.deflection);
    };
    for (int i = 0; i < 300; ++i) go(-5e-3);
    for (int i = 1; i <= 600; ++i) go(-5e-3 + i * 1e-5);
    CHECK(count_events(hand, StringEventKind::kTone) == 1);
    CHECK(last_event(hand, StringEventKind::kTone).amplitude == within(most, 1e-9));
  }
}

TEST_CASE("a tick without time changes nothing and holds the force") {
  StringHand hand = hand_on(98.0);
  pluck(hand, 5e-3);
  glide_to(hand, -3e-3, 5);
  const StringState before = hand.state;
  const double force = hand.response.vibration_force;
  CHECK(force != 0.0);
  // Whatever the sample may claim.
  for (const double distance : {-3e-3, -5e-3, 5e-3, -3e-3}) {
    move_to(hand, distance, 0);
    CHECK(hand.events.empty());
    CHECK(hand.response.vibration_force == force);
    CHECK(hand.state.vibration.energy == before.vibration.energy);
    CHECK(hand.state.vibration.phase == before.vibration.phase);
    CHECK(hand.state.detector.deflection == before.detector.deflection);
  }
}

TEST_CASE("a release is found with ticks of 5 ms and of a second, at its instant") {
  for (const std::int64_t dt_ns : {std::int64_t{5'000'000}, std::int64_t{1'000'000'000}}) {
    StringHand hand = hand_on(98.0);
    move_to(hand, -3e-3, dt_ns);
    move_to(hand, -3e-3, dt_ns);
    move_to(hand, 1e-3, dt_ns);
    CHECK(count_events(hand, StringEventKind::kRelease) == 1);
    CHECK(last_event(hand, StringEventKind::kRelease).t_ns == 2 * dt_ns + 3 * dt_ns / 4);
    CHECK(std::isfinite(hand.state.vibration.energy));
    move_to(hand, 0.05, dt_ns);
    CHECK(std::isfinite(hand.response.radius_growth));
  }
}

TEST_CASE("the same ticks give the same bits") {
  StringHand one = hand_on(98.0);
  StringHand other = hand_on(98.0);
  for (StringHand* hand : {&one, &other}) {
    pluck(*hand, 3e-3);
    pluck(*hand, 2e-3);
    glide_to(*hand, 1e-3, 30);
  }
  CHECK(one.response.vibration_force == other.response.vibration_force);
  CHECK(one.state.vibration.energy == other.state.vibration.energy);
  CHECK(one.state.vibration.phase == other.state.vibration.phase);
}

}  // namespace
}  // namespace hapticd::test
