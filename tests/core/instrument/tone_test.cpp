// The fields of tones and of the other events.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/instrument/deflection.h"
#include "tests/core/instrument/string_hand.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

/// Presses to a deflection, rests, and slips off.
StringHand plucked(InstrumentOptions options, double deflection, double lambda = 0.5,
                   double frequency = 98.0) {
  StringHand hand;
  hand.string = sounding_string(frequency);
  hand.options = options;
  hand.lambda = lambda;
  hand.tangential_speed = 0.7;
  pluck(hand, deflection);
  return hand;
}

StringEvent tone_of(const StringHand& hand) { return last_event(hand, StringEventKind::kTone); }

TEST_CASE("a tone tells string, pitch, decay, place and speeds") {
  const StringHand hand = plucked({}, 2e-3, 0.3, 110.0);
  const StringEvent tone = tone_of(hand);
  CHECK(tone.string == 7);
  CHECK(tone.frequency == 110.0);
  CHECK(tone.decay == 0.5);
  CHECK(tone.lambda == 0.3);
  CHECK(tone.amplitude == within(2e-3, 1e-4));
  CHECK(tone.normal_speed < 0.0);
  CHECK(tone.tangential_speed == 0.7);
  CHECK(tone.glide_cents == 0.0);
  CHECK(tone.glide_decay == 0.0);
  CHECK(tone.partial_count == 0);
}

TEST_CASE("the level is amplitude or force over its reference, times the gain, at most 1") {
  InstrumentOptions options;
  options.tones.reference_amplitude = 4e-3;
  CHECK(tone_of(plucked(options, 1e-3)).level == within(0.25, 1e-4));
  options.tones.gain = 2.0;
  CHECK(tone_of(plucked(options, 1e-3)).level == within(0.5, 1e-4));
  CHECK(tone_of(plucked(options, 3e-3)).level == 1.0);
  options.tones.gain = 0.0;
  CHECK(tone_of(plucked(options, 3e-3)).level == 0.0);

  options.tones = ToneOptions{};
  options.tones.level = ToneLevel::kForce;
  options.tones.reference_force = 2.0;
  const StringHand hand = plucked(options, 3e-3);
  const double force = deflection_force(hand.string, 0.5, 3e-3);
  CHECK(tone_of(hand).level == within(force / 2.0, 2e-4));
  options.tones.reference_force = 0.01;
  CHECK(tone_of(plucked(options, 3e-3)).level == 1.0);
}

TEST_CASE("glide starts at the cents of the amplitude and fades twice as fast as it") {
  InstrumentOptions options;
  options.pitch_glide = true;
  const StringHand hand = plucked(options, 5e-3);
  // Published for 5 mm at the middle of this string: EA of 69 kN against 30 N.
  const double half = 0.55;
  const double stretch = 2.0 * (std::hypot(half, 5e-3) - half);
  const double F_i = hand.string.axial_stiffness * stretch / 1.1;
  const double pi = 3.14159265358979323846;
  const double cents = 1200.0 * std::log2(std::sqrt(1.0 + F_i / 60.0 * (1.0 + 4.0 / (pi * pi))));
  CHECK(tone_of(hand).glide_cents == within(cents, 1e-3));
  CHECK(tone_of(hand).glide_decay == 0.25);
}

TEST_CASE("however slowly a hand lifts, a tone has the largest deflection of its touch") {
  for (const double speed : {0.02, 0.1, 0.5, 3.0}) {
    CAPTURE(speed);
    StringHand hand;
    hand.string = sounding_string(98.0);
    hand.lambda = 0.3;
    glide_to(hand, -4e-3, 100);
    const double deflection = hand.touch.deflection;
    while (count_events(hand, StringEventKind::kTone) == 0) {
      move_to(hand, hand.distance + 1e-3 * speed);
    }
    CHECK(tone_of(hand).amplitude == within(deflection, 1e-12));
  }
}

TEST_CASE("the level by force is the largest force of the touch, vibration included") {
  InstrumentOptions options;
  options.tones.level = ToneLevel::kForce;
  for (const double speed : {0.05, 0.2, 0.7}) {
    for (const bool rings : {false, true}) {
      CAPTURE(speed);
      CAPTURE(rings);
      StringHand hand;
      hand.string = sounding_string(98.0);
      hand.string.touch_decay = 0.5;
      hand.options = options;
      if (rings) pluck(hand, 3e-3);
      double felt = 0.0;
      const double from = hand.distance;
      for (int k = 1; k <= 20; ++k) {
        move_to(hand, from + k / 20.0 * (-4e-3 - from));
        if (hand.distance < 0.0) {
          felt = std::fmax(felt, hand.touch.force + hand.response.vibration_force);
        }
      }
      hand.log.clear();
      while (count_events(hand, StringEventKind::kTone) == 0) {
        felt = std::fmax(felt, hand.touch.force + hand.response.vibration_force);
        move_to(hand, hand.distance + 1e-3 * speed);
      }
      CHECK(tone_of(hand).level == within(felt, 1e-12));
    }
  }
}

TEST_CASE("switched off, tones are not sent, but the string rings") {
  InstrumentOptions options;
  options.tones.enabled = false;
  const StringHand hand = plucked(options, 3e-3);
  CHECK(count_events(hand, StringEventKind::kTone) == 0);
  CHECK(count_events(hand, StringEventKind::kRelease) == 1);
  CHECK(hand.state.vibration.energy > 0.0);
}

TEST_CASE("a slack string and one without tuning are plucked without a tone") {
  for (const bool slack : {true, false}) {
    StringHand hand;
    StringParameters parameters = string_parameters(1.1, slack ? 0.0 : 30.0, 1.9e11, 0.34e-3);
    if (!slack) parameters.frequency = 0.0;
    hand.string = derive_string(parameters);
    pluck(hand, 3e-3);
    CHECK(count_events(hand, StringEventKind::kRelease) == 1);
    CHECK(count_events(hand, StringEventKind::kTone) == 0);
    CHECK(hand.state.vibration.energy == 0.0);
    CHECK(hand.response.vibration_force == 0.0);
    CHECK_FALSE(awake(hand.state));
  }
}

TEST_CASE("touch, press, release, tone and radius come in the order of their instants") {
  const StringHand hand = plucked({}, 3e-3);
  REQUIRE(hand.log.size() == 6);
  const auto kind = [&hand](std::size_t i) { return hand.log[i].kind; };
  CHECK(kind(0) == StringEventKind::kTouch);
  CHECK(kind(1) == StringEventKind::kRadius);
  CHECK(kind(2) == StringEventKind::kPress);
  CHECK(kind(3) == StringEventKind::kRelease);
  CHECK(kind(4) == StringEventKind::kTone);
  CHECK(kind(5) == StringEventKind::kRadius);
  for (std::size_t i = 1; i < hand.log.size(); ++i) CHECK(hand.log[i - 1].t_ns <= hand.log[i].t_ns);
  CHECK(hand.log[1].radius_phase == RadiusPhase::kPress);
  CHECK(hand.log[5].radius_phase == RadiusPhase::kRelease);
  CHECK(hand.log[5].amplitude == hand.log[4].amplitude);
  CHECK(hand.log[5].decay == 0.5);
  CHECK(hand.log[5].frequency == 98.0);
}

TEST_CASE("the end of a touch tells its largest force, a release also its last deflection") {
  StringHand hand;
  hand.string = sounding_string(98.0);
  glide_to(hand, -4e-3, 50);
  const double largest = hand.touch.force;
  glide_to(hand, -2e-3, 50);
  const double deflection = hand.touch.deflection;
  move_to(hand, 1e-3);
  const StringEvent release = last_event(hand, StringEventKind::kRelease);
  CHECK(release.force == largest);
  CHECK(release.deflection == deflection);
  move_to(hand, -0.1e-3);
  const double lightly = hand.touch.force;
  move_to(hand, 0.02);
  const StringEvent leave = last_event(hand, StringEventKind::kLeave);
  CHECK(leave.force == lightly);
  CHECK(leave.deflection == 0.0);
}

TEST_CASE("events beyond the capacity of a tick are counted, not written") {
  StringHand hand;
  hand.string = sounding_string(98.0);
  move_to(hand, -3e-3);
  StringEvents full;
  while (!full.full()) full.push_back(StringEvent{});
  hand.touch.distance_before = -3e-3;
  hand.touch.distance = 1e-3;
  hand.touch.time = {2 * kTick_ns, kTick_ns};
  hand.response = respond({0, hand.string, hand.options, hand.state}, hand.touch, full);
  CHECK(full.overflow() == 3);
  CHECK(hand.state.level == StringPhase::kFundamental);
}

}  // namespace
}  // namespace hapticd::test
