// Modes under a finger: statics, the wave a finger sends out, damping, and the ledger of energy
// under fingers that try to break it. How close the force comes to the truth: modal_accuracy_test.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "core/instrument/modal_string.h"
#include "core/instrument/string_parameters.h"
#include "tests/support/modal_displacement.h"
#include "tests/support/no_heap.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr long double kPiL = std::numbers::pi_v<long double>;
constexpr std::int64_t kTick_ns = 1'000'000;

StringConstants make_string(double frequency, double inharmonicity = 0.0) {
  StringParameters parameters;
  parameters.p_WB = {1.1, 0.0, 0.0};
  parameters.frequency = frequency;
  parameters.inharmonicity = inharmonicity;
  return derive_string(parameters);
}

ModalString at_rest(int count) {
  ModalString modes;
  modes.count = count;
  return modes;
}

TEST_CASE("modes and what they leave out are together as compliant as the string") {
  SplitMix64 random(1);
  for (int i = 0; i < 300; ++i) {
    const StringConstants string = make_string(random.uniform(20.0, 1000.0));
    const double lambda = i == 0 ? 0.0 : i == 1 ? 1.0 : random.uniform();
    const int count = static_cast<int>(random.below(kMaxModes + 1));
    // sum over n > N of 2 L sin^2(n pi lambda) / (n^2 pi^2 T), from what the first N leave of the
    // whole.
    long double rest = lambda * (1.0L - lambda);
    for (int n = 1; n <= count; ++n) {
      const long double shape = std::sin(n * kPiL * static_cast<long double>(lambda));
      rest -= 2 * shape * shape / (n * kPiL * n * kPiL);
    }
    const long double scale = string.length / string.tension;
    const double residual = residual_compliance(string, lambda, count);
    CHECK(residual >= 0.0);
    CHECK(std::abs(residual - static_cast<double>(rest * scale)) <= 1e-15 * 0.04);
  }
}

TEST_CASE("a slow press feels the whole string's static stiffness, however few the modes") {
  for (const double inharmonicity : {0.0, 1e-2}) {
    const StringConstants string = make_string(98.0, inharmonicity);
    for (const double lambda : {1e-4, 0.1, 0.5, 0.9}) {
      for (const int count : {0, 1, 5, 64}) {
        for (const int steps : {1, 16}) {
          ModalString modes = at_rest(count);
          ModalTouch touch{};
          double D = -1e-3;
          for (int i = 1; i <= 900; ++i) {
            const double D_after = std::min(4e-3, D + 5e-5);
            touch = touch_modes(string, {lambda, D, D_after, 1000.0, steps},
                                {i * kTick_ns, kTick_ns}, modes);
            D = D_after;
          }
          const double k0 = 30.0 / (1.1 * lambda * (1.0 - lambda));
          CHECK(touch.force == doctest::Approx(4e-3 / (1.0 / k0 + 1e-3)).epsilon(1e-8));
          CHECK(modes.t_ns == 900 * kTick_ns);
        }
      }
    }
  }
}

TEST_CASE("a finger that starts to press sends a wave out, whose force is known until it returns") {
  const StringConstants string = make_string(65.4);
  const double impedance = 30.0 / (2.0 * 1.1 * 65.4);
  const double speed = 0.2;
  for (const double stiffness : {300.0, 1000.0}) {
    ModalString modes = at_rest(64);
    const double rate = stiffness / (2.0 * impedance);
    // The wave is back at mid-span after 1 / (2 f_1) = 7.6 ms.
    for (int i = 0; i < 7; ++i) {
      const double from = i * 1e-3;
      const double to = from + 1e-3;
      const ModalTouch touch = touch_modes(string, {0.5, speed * from, speed * to, stiffness, 64},
                                           {(i + 1) * kTick_ns, kTick_ns}, modes);
      // F = 2 Z v (1 - exp(-k t / (2 Z))), its mean over the tick; touch damping bends it a little.
      const double mean =
          2.0 * impedance * speed *
          (1.0 + (std::exp(-rate * to) - std::exp(-rate * from)) / (rate * (to - from)));
      CHECK(touch.force == doctest::Approx(mean).epsilon(0.25 * to / string.touch_decay + 0.01));
    }
  }
}

TEST_CASE("a finger that stays clear leaves the string to its friction") {
  const StringConstants string = make_string(65.4, 1e-4);
  for (const int steps : {1, 64}) {
    ModalString modes;
    pluck_modes(string, {0.2, 3e-3, 2e-3}, 24, modes);
    const ModalString plucked = modes;
    for (int i = 1; i <= 25; ++i) {
      // At the edge of what it can reach, so that some ticks are stepped and some are not.
      const ModalTouch touch =
          touch_modes(string, {0.3, -4e-3, -4e-3, 1000.0, steps}, {i * kTick_ns, kTick_ns}, modes);
      CHECK(touch.force == 0.0);
      CHECK(touch.work == 0.0);
    }
    for (int n = 1; n <= 24; ++n) {
      const auto k = static_cast<std::size_t>(n - 1);
      // q'' + 2 q' / T_d + omega^2 q = 0
      const long double omega = 2 * kPiL * n * 65.4L * std::sqrt((1 + 1e-4L * n * n) / (1 + 1e-4L));
      const long double gamma = 1 / 0.03L;
      const long double damped = std::sqrt(omega * omega - gamma * gamma);
      const long double start = 2 * kPiL * static_cast<long double>(plucked.phase[k]) / 0x1p64L;
      const long double q0 = plucked.amplitude[k] * std::cos(start);
      const long double v0 = -plucked.amplitude[k] * std::sin(start) * omega;
      const long double t = 25e-3L;
      const long double q =
          std::exp(-gamma * t) *
          (q0 * std::cos(damped * t) + (v0 + gamma * q0) / damped * std::sin(damped * t));
      const long double phase = 2 * kPiL * static_cast<long double>(modes.phase[k]) / 0x1p64L;
      CHECK(std::abs(static_cast<double>(modes.amplitude[k] * std::cos(phase) - q)) <= 1e-14);
    }
  }
}

TEST_CASE("before the touch the string decays as a free one") {
  const StringConstants string = make_string(65.4);
  ModalString modes;
  pluck_modes(string, {0.2, 3e-3}, 8, modes);
  const double before = modal_energy(string, modes, string.decay, 99 * kTick_ns);
  ModalString touched = modes;
  const ModalTouch touch =
      touch_modes(string, {0.3, -1.0, -1.0, 1000.0, 4}, {99 * kTick_ns, 0}, touched);
  CHECK(touch.force == 0.0);
  CHECK(modal_energy(string, touched, string.touch_decay, 99 * kTick_ns) ==
        doctest::Approx(before).epsilon(1e-13));
}

TEST_CASE("modes with a node under the finger do not feel it") {
  const StringConstants string = make_string(110.0);
  ModalString pressed;
  pluck_modes(string, {0.2, 3e-3}, 12, pressed);
  ModalString clear = pressed;
  for (int i = 1; i <= 20; ++i) {
    const ModalTouch touch =
        touch_modes(string, {0.5, 2e-3, 2e-3, 1000.0, 16}, {i * kTick_ns, kTick_ns}, pressed);
    CHECK(touch.force >= 0.0);
    (void)touch_modes(string, {0.3, -1.0, -1.0, 1000.0, 16}, {i * kTick_ns, kTick_ns}, clear);
  }
  for (std::size_t k = 0; k < 12; ++k) {
    if (k % 2 == 1) {
      CHECK(pressed.amplitude[k] == doctest::Approx(clear.amplitude[k]).epsilon(1e-12));
      const auto apart = static_cast<std::int64_t>(pressed.phase[k] - clear.phase[k]);
      CHECK(std::abs(static_cast<double>(apart)) <= 1e-12 * 0x1p64);
    } else {
      CHECK(std::abs(pressed.amplitude[k] - clear.amplitude[k]) >= 1e-7);
    }
  }
}

TEST_CASE("on an end the finger presses itself alone") {
  const StringConstants string = make_string(65.4);
  for (const double lambda : {0.0, 1.0}) {
    ModalString modes;
    pluck_modes(string, {0.2, 3e-3}, 16, modes);
    const ModalTouch touch =
        touch_modes(string, {lambda, 1e-3, 3e-3, 500.0, 64}, {kTick_ns, kTick_ns}, modes);
    CHECK(touch.force == doctest::Approx(1.0).epsilon(1e-12));
  }
}

TEST_CASE("in a tick without duration nothing moves") {
  const StringConstants string = make_string(65.4);
  ModalString modes;
  pluck_modes(string, {0.2, 3e-3, 0.0, kTick_ns}, 16, modes);
  const double w = modal_displacement(modes, 0.4, string.decay, kTick_ns);
  const double energy = modal_energy(string, modes, string.decay, kTick_ns);
  const ModalTouch touch = touch_modes(string, {0.4, 5e-3, 5e-3, 800.0, 8}, {kTick_ns, 0}, modes);
  const double spring = 1.0 / (1.0 / 800.0 + residual_compliance(string, 0.4, 16));
  CHECK(touch.force == doctest::Approx(spring * (5e-3 - w)).epsilon(1e-12));
  CHECK(modal_energy(string, modes, string.decay, kTick_ns) ==
        doctest::Approx(energy).epsilon(1e-13));
  CHECK(touch.stored == doctest::Approx(touch.stored_before).epsilon(1e-12));
}

TEST_CASE("a slack string gives way, one without tuning is a static spring") {
  StringParameters parameters;
  parameters.p_WB = {1.1, 0.0, 0.0};
  parameters.tension = 0.0;
  parameters.frequency = 65.4;
  ModalString modes = at_rest(16);
  CHECK(touch_modes(derive_string(parameters), {0.3, 1e-3, 2e-3, 1000.0, 8}, {kTick_ns, kTick_ns},
                    modes)
            .force == 0.0);
  parameters.tension = 30.0;
  parameters.frequency = 0.0;
  modes = at_rest(0);
  const double k0 = 30.0 / (1.1 * 0.3 * 0.7);
  CHECK(touch_modes(derive_string(parameters), {0.3, 2e-3, 2e-3, 1000.0, 8}, {kTick_ns, kTick_ns},
                    modes)
            .force == doctest::Approx(2e-3 / (1.0 / k0 + 1e-3)).epsilon(1e-12));
}

TEST_CASE("a touch leaves the heap alone") {
  const StringConstants string = make_string(65.4);
  ModalString modes;
  pluck_modes(string, {0.2, 3e-3}, 64, modes);
  const NoHeapScope no_heap;
  (void)touch_modes(string, {0.3, 1e-3, 2e-3, 1000.0, 64}, {kTick_ns, kTick_ns}, modes);
}

}  // namespace
}  // namespace hapticd::test
