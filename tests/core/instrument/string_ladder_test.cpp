// The ladder of a string: asleep, bent, ringing with one mode or many, and back, with the energy
// continuous at every change of level.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>

#include "core/instrument/modal_string.h"
#include "tests/core/instrument/string_hand.h"
#include "tests/support/modal_displacement.h"

namespace hapticd::test {
namespace {

constexpr double kPi2 = 2.0 * 3.14159265358979323846;

StringHand hand_on(double frequency, int modes = 0) {
  StringHand hand;
  hand.string = sounding_string(frequency);
  hand.options.modes = modes;
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
  CHECK(hand.state.vibration.released_energy == doctest::Approx(E0).epsilon(1e-6));
  CHECK(hand.state.tank.energy == hand.state.vibration.energy);
  CHECK(envelope(hand.string, hand.state, 0.5, hand.touch.time.t_ns) ==
        doctest::Approx(delta).epsilon(1e-3));
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
  CHECK(rang_s == doctest::Approx(asleep_s).epsilon(2e-3));
  CHECK(energy < 1.01e-4 * E0);
  CHECK(hand.state.vibration.energy == 0.0);
  CHECK(hand.state.tank.energy == 0.0);
}

TEST_CASE("with modes a pluck rings with theirs: the closed form's energy, place by place") {
  for (const double lambda : {0.1, 0.3, 0.5}) {
    StringHand hand = hand_on(98.0, 32);
    hand.lambda = lambda;
    const double delta = 2e-3;
    pluck(hand, delta);
    CHECK(hand.state.level == StringPhase::kModes);
    // Mode n of a plucked ideal string holds T pi^2 n^2 A_n^2 / (4 L),
    // A_n = 2 delta sin(n pi lambda) / (n^2 pi^2 lambda (1 - lambda)).
    double E0 = 0.0;
    const double pi = 0.5 * kPi2;
    for (int n = 1; n <= 32; ++n) {
      const double amplitude =
          2.0 * delta * std::sin(n * pi * lambda) / (n * n * pi * pi * lambda * (1.0 - lambda));
      E0 += 30.0 * pi * pi * n * n * amplitude * amplitude / (4.0 * 1.1);
    }
    CHECK(hand.state.vibration.released_energy == doctest::Approx(E0).epsilon(1e-9));
    CHECK(modal_energy(hand.string, hand.modes, hand.string.decay, hand.touch.time.t_ns) ==
          doctest::Approx(hand.state.vibration.energy).epsilon(1e-12));
    // What is drawn where it was plucked is what was drawn aside.
    CHECK(last_event(hand, StringEventKind::kTone).amplitude ==
          doctest::Approx(delta).epsilon(1e-4));
  }
}

TEST_CASE("modes swing as those of a string let go at the instant of the release") {
  StringHand hand = hand_on(98.0, 24);
  hand.lambda = 0.3;
  pluck(hand, 2e-3);
  const std::int64_t released_ns = last_event(hand, StringEventKind::kTone).t_ns;
  const double pi = 0.5 * kPi2;
  for (const double lambda : {0.2, 0.3, 0.7}) {
    const double t = static_cast<double>(hand.touch.time.t_ns - released_ns) * 1e-9;
    double truth = 0.0;
    for (int n = 1; n <= 24; ++n) {
      const double amplitude = 2.0 * 2e-3 * std::sin(n * pi * 0.3) / (n * n * pi * pi * 0.3 * 0.7);
      truth += amplitude * std::cos(kPi2 * 98.0 * n * t) * std::sin(n * pi * lambda);
    }
    truth *= std::exp(-t / 0.5);
    CHECK(std::abs(modal_displacement(hand.modes, lambda, 0.5, hand.touch.time.t_ns) - truth) <
          1e-10);
  }
}

TEST_CASE("the energy is the same before and after every change between fundamental and modes") {
  StringHand hand = hand_on(98.0, 16);
  pluck(hand, 3e-3);
  REQUIRE(hand.state.level == StringPhase::kModes);
  const auto closed_form = [&hand](std::int64_t t_ns) {
    return energy_at(hand.state.vibration, t_ns);
  };

  // Down: the scene no longer asks for modes.
  hand.options.modes = 0;
  double expected = closed_form(hand.touch.time.t_ns + kTick_ns);
  move_to(hand, hand.distance);
  CHECK(hand.state.level == StringPhase::kFundamental);
  CHECK(hand.state.vibration.energy == doctest::Approx(expected).epsilon(1e-14));

  // Up again, with the next touch and not before.
  hand.options.modes = 16;
  move_to(hand, hand.distance);
  CHECK(hand.state.level == StringPhase::kFundamental);
  move_to(hand, 8e-3);
  expected = closed_form(hand.touch.time.t_ns + kTick_ns);
  hand.distance = 5e-3;
  move_to(hand, 1e-3);
  CHECK(hand.state.level == StringPhase::kModes);
  // Touched in the middle of a tick: damped a little more than in air.
  CHECK(hand.state.vibration.energy < expected);
  CHECK(hand.state.vibration.energy > expected * std::exp(-2.0 * 1e-3 / 0.03));
  CHECK(modal_energy(hand.string, hand.modes, 0.03, hand.touch.time.t_ns) < expected);
}

TEST_CASE("promoted to modes, the string goes on where it was") {
  StringHand hand = hand_on(98.0);
  pluck(hand, 3e-3);
  REQUIRE(hand.state.level == StringPhase::kFundamental);
  // A touch at the very end of a tick: nothing has happened since.
  hand.options.modes = 8;
  hand.distance = 5e-3;
  const double reach = envelope(hand.string, hand.state, 0.5, hand.touch.time.t_ns);
  move_to(hand, std::nextafter(reach, 0.0));
  REQUIRE(hand.state.level == StringPhase::kModes);
  CHECK(modal_energy(hand.string, hand.modes, 0.5, hand.modes.t_ns) ==
        doctest::Approx(hand.state.vibration.energy).epsilon(0.07));
  // Displacement into the string against displacement towards the tool.
  CHECK(modal_displacement(hand.modes, 0.5, 0.5, hand.modes.t_ns) ==
        doctest::Approx(-displacement(hand.state.vibration)).epsilon(0.05));
}

TEST_CASE("a ringing string under a finger falls still and is bent, with all its events") {
  for (const int modes : {0, 8}) {
    StringHand hand = hand_on(98.0, modes);
    pluck(hand, 3e-3);
    glide_to(hand, -1e-3, 20);
    const StringPhase ringing = modes > 0 ? StringPhase::kModes : StringPhase::kFundamental;
    REQUIRE(hand.state.level == ringing);
    const double E0 = hand.state.vibration.released_energy;
    double energy = hand.state.vibration.energy;
    for (int i = 0; i < 500 && hand.state.level == ringing; ++i) {
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
}

TEST_CASE("no string climbs above its own level, nor above what the scene models") {
  struct Case {
    StringDetail most;
    bool vibration;
    int modes;
    StringPhase touched;
    StringPhase released;
  };
  const std::array cases = {
      Case{StringDetail::kLine, true, 8, StringPhase::kAsleep, StringPhase::kAsleep},
      Case{StringDetail::kStatic, true, 8, StringPhase::kStatic, StringPhase::kAsleep},
      Case{StringDetail::kFundamental, true, 8, StringPhase::kStatic, StringPhase::kFundamental},
      Case{StringDetail::kModes, true, 8, StringPhase::kStatic, StringPhase::kModes},
      Case{StringDetail::kModes, true, 0, StringPhase::kStatic, StringPhase::kFundamental},
      Case{StringDetail::kModes, false, 8, StringPhase::kStatic, StringPhase::kAsleep},
  };
  for (const Case& c : cases) {
    StringHand hand = hand_on(98.0, c.modes);
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

TEST_CASE("a free string with modes decays in closed form, whatever the ticks") {
  StringHand even = hand_on(98.0, 16);
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
  CHECK(even.state.vibration.energy == doctest::Approx(truth).epsilon(1e-13));
  for (const double lambda : {0.1, 0.35, 0.5}) {
    CHECK(modal_displacement(odd.modes, lambda, 0.5, odd.touch.time.t_ns) ==
          doctest::Approx(modal_displacement(even.modes, lambda, 0.5, even.touch.time.t_ns))
              .epsilon(1e-9));
  }
}

}  // namespace
}  // namespace hapticd::test
