// The ladder of a string: asleep, bent, ringing, and back, with the energy continuous at every
// change of level.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>

#include "tests/core/instrument/string_hand.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kPi2 = 2.0 * 3.14159265358979323846;

StringHand hand_on(double frequency) {
  StringHand hand;
  hand.string = sounding_string(frequency);
  return hand;
}

TEST_CASE("a string nobody has touched sleeps and stays asleep") {
  StringHand hand = hand_on(98.0);
  hand.distance = 0.1;
  for (int i = 0; i < 10; ++i) move_to(hand, 0.1);
  CHECK(hand.state.level == StringPhase::kAsleep);
  CHECK_FALSE(awake(hand.state));
  CHECK(hand.log.empty());
  CHECK(hand.response.vibration_force == 0.0);
  CHECK(hand.response.radius_growth == 0.0);
  CHECK(envelope(hand.string, hand.state, 0.5, 0) == 0.0);
}

TEST_CASE("a touched string is bent, and sleeps again when it is left without a pluck") {
  StringHand hand = hand_on(98.0);
  move_to(hand, -0.2e-3);
  CHECK(hand.state.level == StringPhase::kStatic);
  CHECK(awake(hand.state));
  CHECK(hand.response.radius_growth == hand.touch.deflection);
  CHECK(hand.response.vibration_force == 0.0);
  move_to(hand, 1e-3);
  CHECK(hand.state.level == StringPhase::kAsleep);
  CHECK_FALSE(awake(hand.state));
  CHECK(hand.response.radius_growth == 0.0);
}

TEST_CASE("a released string rings with pi^2 T delta^2 / (4 L), and sleeps when that has decayed") {
  StringHand hand = hand_on(98.0);
  const double delta = 3e-3;
  glide_to(hand, -delta - deflection_force(hand.string, 0.5, delta) / 1000.0, 100);
  for (int i = 0; i < 600; ++i) move_to(hand, hand.distance);
  move_to(hand, 1e-3);
  CHECK(hand.state.level == StringPhase::kFundamental);
  const double E0 = kPi2 * kPi2 / 4.0 * 30.0 * delta * delta / (4.0 * 1.1);
  CHECK(hand.state.vibration.released_energy == within(E0, 1e-6));
  CHECK(hand.state.tank.energy == hand.state.tank.full);
  CHECK(envelope(hand.string, hand.state, 0.5, hand.touch.time.t_ns) == within(delta, 1e-3));
  glide_to(hand, 0.1, 50);

  // exp(-2 t / T_d) = 1e-4 at 4.6 T_d.
  const double asleep_s = 0.5 * 0.5 * std::log(1e4);
  const std::int64_t released_ns = last_event(hand, StringEventKind::kRelease).t_ns;
  double energy = hand.state.vibration.energy;
  while (awake(hand.state)) {
    CHECK(hand.state.vibration.energy > 1e-4 * hand.state.vibration.released_energy);
    energy = hand.state.vibration.energy;
    move_to(hand, hand.distance);
  }
  const double rang_s = static_cast<double>(hand.touch.time.t_ns - released_ns) * 1e-9;
  CHECK(rang_s == within(asleep_s, 2e-3));
  CHECK(energy < 1.01e-4 * E0);
  CHECK(hand.state.vibration.energy == 0.0);
  CHECK(hand.state.tank.energy == 0.0);
}

TEST_CASE("a ringing string under a finger falls still and is bent, with all its events") {
  StringHand hand = hand_on(98.0);
  pluck(hand, 3e-3);
  glide_to(hand, -1e-3, 20);
  REQUIRE(hand.state.level == StringPhase::kFundamental);
  const double E0 = hand.state.vibration.released_energy;
  double energy = hand.state.vibration.energy;
  for (int i = 0; i < 500 && hand.state.level == StringPhase::kFundamental; ++i) {
    energy = hand.state.vibration.energy;
    move_to(hand, hand.distance);
    CHECK(hand.state.vibration.energy <= energy);
  }
  CHECK(hand.state.level == StringPhase::kStatic);
  CHECK(energy > 1e-4 * E0);
  CHECK(energy * std::exp(-2.0 * 1e-3 / 0.03) < 1.001e-4 * E0);
  CHECK(hand.response.vibration_force == 0.0);
  const StringEvent radius = last_event(hand, StringEventKind::kRadius);
  CHECK(radius.radius_phase == RadiusPhase::kPress);
  CHECK(radius.deflection == hand.touch.deflection);
  glide_to(hand, 2e-3, 200);
  while (awake(hand.state)) move_to(hand, 2e-3);
  CHECK(hand.state.level == StringPhase::kAsleep);
}

TEST_CASE("no string climbs above its own level, nor above what the scene models") {
  struct Case {
    StringDetail most;
    bool vibration;
    StringPhase touched;
    StringPhase released;
  };
  const std::array cases = {
      Case{StringDetail::kLine, true, StringPhase::kAsleep, StringPhase::kAsleep},
      Case{StringDetail::kStatic, true, StringPhase::kStatic, StringPhase::kAsleep},
      Case{StringDetail::kFundamental, true, StringPhase::kStatic, StringPhase::kFundamental},
      Case{StringDetail::kModes, true, StringPhase::kStatic, StringPhase::kFundamental},
      Case{StringDetail::kModes, false, StringPhase::kStatic, StringPhase::kAsleep},
  };
  for (const Case& c : cases) {
    StringHand hand = hand_on(98.0);
    hand.string.max_level = c.most;
    hand.options.vibration = c.vibration;
    move_to(hand, -2e-3);
    CHECK(hand.state.level == c.touched);
    CHECK(awake(hand.state));
    move_to(hand, 2e-3);
    CHECK(hand.state.level == c.released);
    const bool rings = c.released >= StringPhase::kFundamental;
    CHECK(awake(hand.state) == rings);
    CHECK(count_events(hand, StringEventKind::kTone) == (rings ? 1 : 0));
    CHECK(count_events(hand, StringEventKind::kTouch) == 1);
    CHECK(count_events(hand, StringEventKind::kRelease) == (c.most == StringDetail::kLine ? 0 : 1));
    CHECK(count_events(hand, StringEventKind::kLeave) == (c.most == StringDetail::kLine ? 1 : 0));
  }
}

TEST_CASE("a string that may no longer ring is still at once") {
  StringHand hand = hand_on(98.0);
  pluck(hand, 3e-3);
  hand.options.vibration = false;
  move_to(hand, hand.distance);
  CHECK_FALSE(awake(hand.state));
  CHECK(hand.state.vibration.energy == 0.0);
  CHECK(last_event(hand, StringEventKind::kRadius).amplitude == 0.0);
}

TEST_CASE("a free string decays in closed form, whatever the ticks") {
  StringHand even = hand_on(98.0);
  pluck(even, 3e-3);
  StringHand odd = even;
  for (int i = 0; i < 300; ++i) move_to(even, even.distance);
  for (const std::int64_t dt_ns : {std::int64_t{5'000'000}, std::int64_t{1}, std::int64_t{0},
                                   std::int64_t{0}, std::int64_t{294'999'999}}) {
    move_to(odd, odd.distance, dt_ns);
  }
  CHECK(odd.touch.time.t_ns == even.touch.time.t_ns);
  CHECK(odd.state.vibration.energy == even.state.vibration.energy);
  const double truth =
      even.state.vibration.anchor_energy *
      std::exp(-2.0 / 0.5 *
               static_cast<double>(even.touch.time.t_ns - even.state.vibration.anchor_ns) * 1e-9);
  CHECK(even.state.vibration.energy == within(truth, 1e-13));
  CHECK(displacement(odd.state.vibration) == within(displacement(even.state.vibration), 1e-9));
}

}  // namespace
}  // namespace hapticd::test
