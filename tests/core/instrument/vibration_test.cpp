// The fundamental after a release against its closed forms in long double.
#include "core/instrument/vibration.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/instrument/deflection.h"
#include "tests/core/instrument/string_hand.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

using Real = long double;

constexpr Real kPiLong = 3.14159265358979323846264338327950288L;

TEST_CASE("the vibration is r exp(-t / T_d) sin(2 pi f t), sampled for ten seconds") {
  for (const double frequency : {65.4, 98.0, 146.8, 1234.5}) {
    const StringConstants string = sounding_string(frequency);
    Vibration vibration = start_vibration(string, fundamental_energy(string, 3e-3), 0.3, 500);
    Real worst = 0;
    const std::int64_t ticks = scaled(10'000);
    for (std::int64_t k = 1; k <= ticks; ++k) {
      advance_vibration(string, false, 500 + k * kTick_ns, vibration);
      const Real t = static_cast<Real>(k) * 1e-3L;
      const Real truth =
          3e-3L * std::exp(-t / 0.5L) * std::sin(2 * kPiLong * static_cast<Real>(frequency) * t);
      worst = std::fmax(worst, std::fabs(static_cast<Real>(displacement(vibration)) - truth));
    }
    // A rounding of 1e-16 in the turns of every tick, at most ten thousand of 1234 turns a second.
    CHECK(worst < 3e-3L * 1e-11L);
  }
}

TEST_CASE("the energy of a fundamental is pi^2 T r^2 / (4 L), and gives the amplitude back") {
  const StringConstants string = sounding_string(98.0);
  SplitMix64 random(11);
  for (int i = 0; i < 1000; ++i) {
    const double r = std::exp2(random.uniform(-40.0, 0.0));
    const Real truth = kPiLong * kPiLong * 30.0L * static_cast<Real>(r) * static_cast<Real>(r) /
                       (4.0L * static_cast<Real>(string.length));
    CHECK(relative_error(fundamental_energy(string, r), truth) < 2e-15L);
    CHECK(fundamental_amplitude(string, fundamental_energy(string, r)) == within(r, 1e-15));
  }
}

TEST_CASE("free decay keeps the energy within 1e-12 of the closed form over a million ticks") {
  StringHand hand;
  hand.string = sounding_string(98.0);
  hand.string.decay = 1000.0;
  hand.distance = 1.0;
  hand.options.sleep_energy = 1e-6;
  hand.state.vibration = start_vibration(hand.string, 1e-3, 0.3, 0);
  hand.state.level = StringPhase::kFundamental;
  Real worst = 0;
  const std::int64_t ticks = scaled(1'000'000);
  for (std::int64_t k = 1; k <= ticks; ++k) {
    hand.touch.distance = hand.touch.distance_before = 1.0;
    hand.touch.time = {k * kTick_ns, kTick_ns};
    hand.response = respond({0, hand.string, hand.options, hand.state}, hand.touch, hand.events);
    const Real truth = 1e-3L * std::exp(-2.0L * static_cast<Real>(k) * 1e-3L / 1000.0L);
    worst = std::fmax(worst, relative_error(hand.state.vibration.energy, truth));
  }
  CHECK(worst < 1e-12L);
  CHECK(hand.state.level == StringPhase::kFundamental);
  CHECK(hand.events.empty());
}

TEST_CASE("energy and phase do not depend on how time is cut into ticks") {
  SplitMix64 random(12);
  const StringConstants string = sounding_string(110.0);
  for (int i = 0; i < 100; ++i) {
    Vibration whole = start_vibration(string, 1e-3, 0.5, 0);
    Vibration parts = whole;
    const auto end = static_cast<std::int64_t>(random.uniform(1e3, 2e9));
    advance_vibration(string, false, end, whole);
    for (std::int64_t t = 0; t < end;) {
      t = std::min(end, t + static_cast<std::int64_t>(random.uniform(0.0, 9e6)));
      advance_vibration(string, false, t, parts);
    }
    CHECK(parts.energy == whole.energy);
    const auto apart = static_cast<std::int64_t>(parts.phase - whole.phase);
    CHECK(std::abs(static_cast<double>(apart)) * 0x1p-64 < 1e-12);
  }
}

TEST_CASE("a phase that wraps a hundred million times is where it should be") {
  const std::int64_t ticks = scaled(100'000'000);
  const StringConstants string = sounding_string(1000.0 + 65.4);
  Vibration vibration = start_vibration(string, 1e-3, 0.5, 0);
  for (std::int64_t k = 1; k <= ticks; ++k)
    advance_vibration(string, false, k * kTick_ns, vibration);
  const Real turns = 1.0654L * static_cast<Real>(ticks);
  const Real apart = static_cast<Real>(vibration.phase) * 0x1p-64L - (turns - std::floor(turns));
  // Frequency, time and turns of a tick are rounded to 2^-53 each.
  CHECK(std::fabs(apart - std::round(apart)) < 3 * 0x1p-53L * static_cast<Real>(ticks));
}

TEST_CASE("a time that stands still or steps back changes nothing") {
  const StringConstants string = sounding_string(98.0);
  Vibration vibration = start_vibration(string, 1e-3, 0.5, 1000);
  advance_vibration(string, true, 5'001'000, vibration);
  const Vibration before = vibration;
  advance_vibration(string, true, 5'001'000, vibration);
  advance_vibration(string, true, 4'000'000, vibration);
  CHECK(vibration.energy == before.energy);
  CHECK(vibration.phase == before.phase);
  CHECK(vibration.t_ns == before.t_ns);
}

TEST_CASE("a change of the decay time bends the decay and nothing else") {
  const StringConstants string = sounding_string(98.0);
  Vibration vibration = start_vibration(string, 1e-3, 0.5, 0);
  advance_vibration(string, false, 100'000'000, vibration);
  const double energy = vibration.energy;
  set_decay(0.03, vibration);
  CHECK(vibration.energy == energy);
  advance_vibration(string, false, 130'000'000, vibration);
  // 0.1 s at a decay of 0.5 s, then 0.03 s at one of 0.03 s.
  const Real truth = 1e-3L * std::exp(-2.0L * (0.1L / 0.5L + 1.0L));
  CHECK(relative_error(vibration.energy, truth) < 1e-14L);
}

TEST_CASE("with glide the phase is the integral of f_1 sqrt(1 + F_i / (2 T) (1 + s / 2))") {
  const StringConstants string = sounding_string(98.0);
  Vibration vibration = start_vibration(string, fundamental_energy(string, 8e-3), 0.5, 0);
  // Simpson's rule on a grid a hundred times finer than the ticks.
  const auto pitch = [&](Real t) {
    const Real r = 8e-3L * std::exp(-t / 0.5L);
    const Real half = 0.5L * static_cast<Real>(string.length);
    const Real stretch = 2 * r * r / (std::hypot(half, r) + half);
    const Real F_i =
        static_cast<Real>(string.axial_stiffness) * stretch / static_cast<Real>(string.length);
    return std::sqrt(1 + F_i / (2.0L * 30.0L) * (1 + 4 / (kPiLong * kPiLong)));
  };
  Real turns = 0;
  Real worst = 0;
  for (int k = 1; k <= 1000; ++k) {
    advance_vibration(string, true, k * kTick_ns, vibration);
    constexpr int kParts = 100;
    const Real h = 1e-3L / kParts;
    for (int j = 0; j < kParts; ++j) {
      const Real t = static_cast<Real>(k - 1) * 1e-3L + static_cast<Real>(j) * h;
      turns += 98.0L * h / 6 * (pitch(t) + 4 * pitch(t + h / 2) + pitch(t + h));
    }
    const Real phase = static_cast<Real>(vibration.phase) * 0x1p-64L;
    const Real apart = phase - (turns - std::floor(turns));
    worst = std::fmax(worst, std::fabs(apart - std::round(apart)));
  }
  CHECK(pitch(0) > 1.01L);
  // The trapezium's error: dt^2 / (3 T_d^2) of the 2 turns that the glide adds.
  CHECK(worst < 2.7e-6L);
}

TEST_CASE("a slack string, one without tuning and one of no length are silent") {
  for (int kind = 0; kind < 3; ++kind) {
    StringConstants string = sounding_string(98.0);
    if (kind == 0) string.tension = 0.0;
    if (kind == 1) string.frequency = 0.0;
    if (kind == 2) string.length = 0.0;
    Vibration vibration = start_vibration(string, fundamental_energy(string, 1e-3), 0.5, 0);
    advance_vibration(string, true, kTick_ns, vibration);
    if (kind != 1) CHECK(vibration.amplitude == 0.0);
    CHECK(displacement(vibration) == 0.0);
    CHECK(std::isfinite(vibration.energy));
  }
}

TEST_CASE("phi is the ratio of sines, at most 1, and finite on the ends") {
  Vibration vibration;
  for (const double place : {0.0, 1e-9, 0.1, 0.5, 0.77, 1.0}) {
    vibration.lambda = place;
    for (const double lambda : {0.0, 1e-9, 0.05, 0.3, 0.5, 0.9, 1.0}) {
      const double phi = shape_factor(vibration, lambda);
      CHECK(phi >= 0.0);
      CHECK(phi <= 1.0);
      const Real here = std::sin(kPiLong * static_cast<Real>(std::fmin(lambda, 1.0 - lambda)));
      const Real there = std::sin(kPiLong * static_cast<Real>(std::fmin(place, 1.0 - place)));
      if (here < there) CHECK(relative_error(phi, here / there) < 1e-8L);
      if (here >= there) CHECK(phi == 1.0);
    }
  }
}

TEST_CASE("k_v is k0 under the finger, at most kc") {
  const StringConstants string = sounding_string(98.0);
  CHECK(vibration_stiffness(string, 0.5) == within(4.0 * 30.0 / 1.1, 1e-14));
  CHECK(vibration_stiffness(string, 0.001) == 1000.0);
  CHECK(vibration_stiffness(string, 0.0) == 1000.0);
  CHECK(vibration_stiffness(string, 1.0) == 1000.0);
  StringConstants slack = string;
  slack.tension = 0.0;
  CHECK(vibration_stiffness(slack, 0.5) == 0.0);
  CHECK(vibration_stiffness(slack, 0.0) == 0.0);
}

}  // namespace
}  // namespace hapticd::test
