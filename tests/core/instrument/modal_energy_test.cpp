// The ledger of a string under fingers that try to break it: nobody gets more out of it than was in
// it or was put in.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "core/instrument/modal_string.h"
#include "core/instrument/string_parameters.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kTick_ns = 1'000'000;
/// Rounding of a ledger, relative to the largest energy in it.
constexpr double kRounding = 1e-11;

StringConstants random_string(SplitMix64& random) {
  StringParameters parameters;
  parameters.p_WB = {random.uniform(0.1, 2.0), 0.0, 0.0};
  parameters.tension = random.uniform(1.0, 200.0);
  parameters.frequency = random.uniform(20.0, 1000.0);
  parameters.inharmonicity = random.chance(0.5) ? 0.0 : random.uniform(0.0, 0.1);
  parameters.decay = std::pow(10.0, random.uniform(-2.0, 3.0));
  parameters.touch_decay = std::pow(10.0, random.uniform(-3.0, 3.0));
  return derive_string(parameters);
}

/// `count` modes after a pluck anywhere.
ModalString random_pluck(const StringConstants& string, int count, SplitMix64& random) {
  const double lambda = random.uniform();
  const double delta = random.uniform(1e-5, 0.02);
  ModalString modes;
  pluck_modes(string, {lambda, delta}, count, modes);
  return modes;
}

TEST_CASE("no finger makes the energy grow by more than its work") {
  SplitMix64 random(1);
  const std::int64_t sessions = scaled(20'000);
  for (std::int64_t session = 0; session < sessions; ++session) {
    const StringConstants string = random_string(random);
    const int count = 1 + static_cast<int>(random.below(kMaxModes));
    const std::uint64_t most_steps = random.chance(0.5) ? 8 : 256;
    const int steps = 1 + static_cast<int>(random.below(most_steps));
    const double stiffness = std::pow(10.0, random.uniform(-1.0, 9.0));
    ModalString modes = random_pluck(string, count, random);
    double lambda = random.uniform();
    double D = random.uniform(-5e-3, 5e-3);
    std::int64_t t_ns = 0;
    for (int i = 0; i < 20; ++i) {
      // Slides, jumps and odd ticks included.
      if (random.chance(0.2)) lambda = random.chance(0.1) ? 0.0 : random.uniform();
      const double D_after =
          random.chance(0.1) ? random.uniform(-0.02, 0.02) : D + random.uniform(-1e-3, 1e-3);
      const auto dt_ns = static_cast<std::int64_t>(random.below(5'000'000));
      const double before = modal_energy(string, modes, string.decay, t_ns);
      t_ns += dt_ns;
      const ModalTouch touch =
          touch_modes(string, {lambda, D, D_after, stiffness, steps}, {t_ns, dt_ns}, modes);
      const double after = modal_energy(string, modes, string.decay, t_ns);
      const double scale = before + touch.stored_before + std::abs(touch.work);
      REQUIRE(touch.force >= 0.0);
      REQUIRE(after + touch.stored <=
              before + touch.stored_before + touch.work + kRounding * scale);
      D = D_after;
    }
  }
}

TEST_CASE("without damping the energy grows by exactly the finger's work") {
  SplitMix64 random(2);
  const std::int64_t sessions = scaled(5'000);
  for (std::int64_t session = 0; session < sessions; ++session) {
    StringConstants string = random_string(random);
    string.touch_decay = 1e30;
    const int count = 1 + static_cast<int>(random.below(kMaxModes));
    const int steps = 1 + static_cast<int>(random.below(64));
    const double stiffness = std::pow(10.0, random.uniform(1.0, 7.0));
    const double lambda = random.uniform();
    ModalString modes = random_pluck(string, count, random);
    double D = -0.01;
    double energy = modal_energy(string, modes, string.decay, 0);
    double largest = energy;
    for (int i = 1; i <= 30; ++i) {
      const double D_after = std::min(3e-3, D + random.uniform(0.0, 1e-3));
      const ModalTouch touch = touch_modes(string, {lambda, D, D_after, stiffness, steps},
                                           {i * kTick_ns, kTick_ns}, modes);
      energy += touch.work;
      largest = std::max(largest, energy);
      const double now = modal_energy(string, modes, 1.0, i * kTick_ns) + touch.stored;
      REQUIRE(std::abs(now - energy) <= 1e-10 * largest);
      D = D_after;
    }
  }
}

/// A hand that moves in step with the fundamental, `amplitude` to and fro about `offset`, `turn`
/// ahead of it. Returns what it gained, as a share of the energy of the pluck.
double gain(const StringConstants& string, int count, int steps, double amplitude, double offset,
            double turn) {
  ModalString modes;
  pluck_modes(string, {0.5, 5e-3}, count, modes);
  const double plucked = modal_energy(string, modes, string.decay, 0);
  const auto hand = [&](double t) {
    return offset + amplitude * std::cos(2.0 * std::numbers::pi * (string.frequency * t + turn));
  };
  // It comes from afar, so that what it pushes on is the string's own motion.
  double D = -0.02;
  double given = 0.0;
  double most = 0.0;
  for (int i = 1; i <= 200; ++i) {
    const double D_after = hand(i * 1e-3);
    const ModalTouch touch =
        touch_modes(string, {0.5, D, D_after, 1000.0, steps}, {i * kTick_ns, kTick_ns}, modes);
    given -= touch.work;
    most = std::max(most, given - touch.stored_before);
    D = D_after;
  }
  return most / plucked;
}

TEST_CASE("a hand that moves with the fundamental gets no more than the pluck put in") {
  SplitMix64 random(3);
  StringParameters parameters;
  parameters.p_WB = {1.1, 0.0, 0.0};
  double most = 0.0;
  const std::int64_t hands = scaled(20'000);
  for (std::int64_t hand = 0; hand < hands; ++hand) {
    // The first one is known to get most of what there is.
    const bool first = hand == 0;
    parameters.frequency = first ? 65.4 : random.uniform(20.0, 450.0);
    parameters.touch_decay = first || random.chance(0.5) ? 1000.0 : 0.03;
    const int count = first || random.chance(0.3) ? 1 : 1 + static_cast<int>(random.below(40));
    const int steps = random.chance(0.5) ? 1 : 16;
    const double amplitude = first ? 1e-2 : std::pow(10.0, random.uniform(-5.0, -2.0));
    const double offset = first ? -4e-3 : random.uniform(-5e-3, 5e-3);
    const double got = gain(derive_string(parameters), count, steps, amplitude, offset,
                            first ? 0.125 : random.uniform());
    REQUIRE(got <= 1.001);
    most = std::max(most, got);
  }
  // The hand does get something, or this tests nothing.
  CHECK(most >= 0.2);
}

TEST_CASE("a touch that comes and goes never feeds the string") {
  SplitMix64 random(4);
  const std::int64_t sessions = scaled(2'000);
  for (std::int64_t session = 0; session < sessions; ++session) {
    const StringConstants string = random_string(random);
    const int count = 1 + static_cast<int>(random.below(kMaxModes));
    ModalString modes = random_pluck(string, count, random);
    double last = modal_energy(string, modes, string.decay, 0);
    for (int i = 1; i <= 40; ++i) {
      // Clear of the string: only the change between free and touched decay acts.
      if (random.chance(0.5)) {
        advance_free_modes(string, 1.0, kTick_ns, modes);
      } else {
        (void)touch_modes(string, {0.3, -1.0, -1.0, 1000.0, 4}, {i * kTick_ns, kTick_ns}, modes);
      }
      const double now = modal_energy(string, modes, string.decay, i * kTick_ns);
      REQUIRE(now <= last * (1.0 + kRounding));
      last = now;
    }
  }
}

}  // namespace
}  // namespace hapticd::test
