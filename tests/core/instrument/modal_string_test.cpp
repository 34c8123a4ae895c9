// Free modes against closed forms in long double: the plucked spectrum, what an uneven release
// leaves of it, rotation, decay, energy.
#include "core/instrument/modal_string.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "core/instrument/string_parameters.h"
#include "tests/support/modal_displacement.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/truth/string_truth.h"

namespace hapticd::test {
namespace {

constexpr long double kPiL = std::numbers::pi_v<long double>;
constexpr double kNanosecond = 1e-9;
constexpr std::array kSomeLambdas = {1e-6, 0.01, 0.1, 0.3, 0.5, 0.77, 1.0 - 1e-6};

StringConstants make_string(double frequency, double inharmonicity = 0.0, double decay = 0.5) {
  StringParameters parameters;
  parameters.p_WB = {1.1, 0.0, 0.0};
  parameters.frequency = frequency;
  parameters.inharmonicity = inharmonicity;
  parameters.decay = decay;
  return derive_string(parameters);
}

long double frequency_of(const StringConstants& string, int n) {
  const long double b = string.inharmonicity;
  return n * static_cast<long double>(string.frequency) * std::sqrt((1 + b * n * n) / (1 + b));
}

/// m omega_n^2, from the potential energy of a stretched string: n^2 pi^2 T / (2 L).
long double stiffness_of(const StringConstants& string, int n) {
  const long double ratio = frequency_of(string, n) / string.frequency;
  return ratio * ratio * kPiL * kPiL * string.tension / (2 * string.length);
}

long double turns_of(std::uint64_t phase) { return static_cast<long double>(phase) / 0x1p64L; }

/// Distance of two phases in turns, at most 1/2.
long double distance(long double a, long double b) { return std::abs(std::remainder(a - b, 1.0L)); }

/// Fourier coefficient 2/L int w sin(n pi x / L) of the triangle, from its two straight parts.
long double triangle_coefficient(long double lambda, long double delta, int n) {
  const long double k = n * kPiL;
  // int_0^a x sin(k x) dx
  const auto part = [&](long double a, long double mirror) {
    return mirror * (std::sin(k * a) - k * a * std::cos(k * a)) / (k * k);
  };
  const long double mirror = n % 2 == 0 ? -1.0L : 1.0L;
  return 2 * delta * (part(lambda, 1.0L) / lambda + part(1 - lambda, mirror) / (1 - lambda));
}

TEST_CASE("the modes of a pluck are the Fourier coefficients of the triangle") {
  for (const double lambda : {0.01, 0.1, 0.3, 0.5, 0.77, 0.99}) {
    for (int n = 1; n <= kMaxModes; ++n) {
      const auto exact = static_cast<double>(triangle_coefficient(lambda, 5e-3L, n));
      CHECK(std::abs(pluck_amplitude(lambda, 5e-3, n) - exact) <= 1e-14 * 5e-3);
    }
  }
}

TEST_CASE("the end of a string cannot be drawn aside, and both ends are alike") {
  for (int n = 1; n <= kMaxModes; ++n) {
    CHECK(pluck_amplitude(0.0, 1e-3, n) == 0.0);
    CHECK(pluck_amplitude(1.0, 1e-3, n) == 0.0);
    const double sign = n % 2 == 0 ? -1.0 : 1.0;
    // 1 - near_end is exact, n times it is not.
    const double near_end = 0x1.2345679p-22;
    CHECK(pluck_amplitude(1.0 - near_end, 1e-3, n) == sign * pluck_amplitude(near_end, 1e-3, n));
    CHECK(pluck_amplitude(near_end, 1e-3, n) ==
          doctest::Approx(2e-3 / (n * std::numbers::pi)).epsilon(1e-6));
  }
}

TEST_CASE("a plucked string moves as the reflected waves of its triangle") {
  const StringConstants string = make_string(65.4, 0.0, 1e3);
  TruthString truth;
  SplitMix64 random(1);
  for (const double pluck_lambda : {0.1, 0.5}) {
    ModalString modes;
    pluck_modes(string, {pluck_lambda, 5e-3}, kMaxModes, modes);
    // The modes above 64 together.
    const double left_out =
        2.0 * 5e-3 /
        (std::numbers::pi * std::numbers::pi * pluck_lambda * (1.0 - pluck_lambda) * kMaxModes);
    std::int64_t t_ns = 0;
    for (int i = 0; i < 200; ++i) {
      const std::int64_t dt_ns = static_cast<std::int64_t>(random.below(2'000'000));
      advance_free_modes(string, 1.0, dt_ns, modes);
      t_ns += dt_ns;
      const double lambda = random.uniform();
      const double time = static_cast<double>(t_ns) * kNanosecond;
      const double expected =
          std::exp(-time / 1e3) * free_displacement(truth, pluck_lambda, 5e-3, lambda, time);
      CHECK(std::abs(modal_displacement(modes, lambda, 1e3, t_ns) - expected) <= left_out);
    }
  }
}

TEST_CASE("a pluck stores the work of drawing the string aside, but for the modes left out") {
  const StringConstants string = make_string(98.0);
  for (const double lambda : kSomeLambdas) {
    for (const int count : {1, 7, 32, 64}) {
      ModalString modes;
      pluck_modes(string, {lambda, 3e-3}, count, modes);
      long double exact = 0.0L;
      for (int n = 1; n <= count; ++n) {
        const long double shape = std::sin(n * kPiL * static_cast<long double>(lambda));
        const long double held =
            string.tension * 3e-3L / (string.length * lambda * (1.0L - lambda));
        exact += held * held * shape * shape / (2 * stiffness_of(string, n));
      }
      const double energy = modal_energy(string, modes, string.decay, 0);
      CHECK(energy == doctest::Approx(static_cast<double>(exact)).epsilon(1e-12));
      const double drawn = 0.5 * 30.0 * 3e-3 * 3e-3 / (1.1 * lambda * (1.0 - lambda));
      CHECK(energy <= drawn);
      if (count == 64 && lambda == 0.3) CHECK(energy >= 0.96 * drawn);
    }
  }
}

TEST_CASE("a mid-string pluck has 81 % of its energy in the fundamental, one at 0.1 has 21 %") {
  const StringConstants string = make_string(65.4);
  for (const double lambda : {0.5, 0.1}) {
    ModalString modes;
    pluck_modes(string, {lambda, 5e-3}, 1, modes);
    const double share = modal_energy(string, modes, 0.5, 0) /
                         (0.5 * 30.0 * 25e-6 / (1.1 * lambda * (1.0 - lambda)));
    CHECK(share == doctest::Approx(lambda == 0.5 ? 0.8106 : 0.2150).epsilon(1e-3));
  }
}

TEST_CASE("a slow release leaves of each mode what the moving rest position leaves ringing") {
  for (const double inharmonicity : {0.0, 1e-3}) {
    const StringConstants string = make_string(110.0, inharmonicity);
    for (const double unload_time : {1e-4, 1e-3, 4.1e-3, 30e-3}) {
      ModalString modes;
      pluck_modes(string, {0.2, 4e-3, unload_time, 77}, 40, modes);
      REQUIRE(modes.count == 40);
      CHECK(modes.t_ns == 77);
      for (int n = 1; n <= 40; ++n) {
        // q + i v = 1/tau int_0^tau exp(-i omega s) ds, by Simpson's rule, times the static q.
        const long double omega = 2 * kPiL * frequency_of(string, n);
        const int panels = 2000;
        long double q = 0.0L;
        long double v = 0.0L;
        for (int i = 0; i <= panels; ++i) {
          const long double weight = i == 0 || i == panels ? 1.0L : (i % 2 == 1 ? 4.0L : 2.0L);
          const long double s = i * static_cast<long double>(unload_time) / panels;
          q += weight * std::cos(omega * s) / (3 * panels);
          v -= weight * std::sin(omega * s) / (3 * panels);
        }
        const long double held = string.tension * 4e-3L / (string.length * 0.2L * 0.8L);
        const long double rest = held * std::sin(n * kPiL * 0.2L) / stiffness_of(string, n);
        const auto k = static_cast<std::size_t>(n - 1);
        const long double angle = 2 * kPiL * turns_of(modes.phase[k]);
        // Modes with a node at the pluck are 0 here, all but 0 there.
        const auto scale = static_cast<double>(std::abs(rest)) + 1e-12;
        CHECK(std::abs(static_cast<double>(modes.amplitude[k] * std::cos(angle) - rest * q)) <=
              1e-6 * scale);
        CHECK(std::abs(static_cast<double>(-modes.amplitude[k] * std::sin(angle) - rest * v)) <=
              1e-6 * scale);
      }
    }
  }
}

TEST_CASE("a million free ticks decay and turn in closed form") {
  const std::int64_t ticks = scaled(1'000'000);
  SplitMix64 random(2);
  for (const double decay : {1.0, 1000.0}) {
    const StringConstants string = make_string(146.8, 1e-4, decay);
    ModalString modes;
    pluck_modes(string, {0.13, 5e-3}, 16, modes);
    const double before = modal_energy(string, modes, decay, 0);
    const ModalString plucked = modes;
    std::int64_t t_ns = 0;
    for (std::int64_t i = 0; i < ticks; ++i) {
      const std::int64_t dt_ns = static_cast<std::int64_t>(random.below(2'000'000));
      advance_free_modes(string, 1.0, dt_ns, modes);
      t_ns += dt_ns;
    }
    const long double time = t_ns * 1e-9L;
    // Beyond this the energy leaves the range of a double.
    if (time / decay < 300) {
      const long double exact = before * std::exp(-2 * time / decay);
      CHECK(modal_energy(string, modes, decay, t_ns) ==
            doctest::Approx(static_cast<double>(exact)).epsilon(1e-12));
    }
    for (int n = 1; n <= modes.count; ++n) {
      const auto k = static_cast<std::size_t>(n - 1);
      CHECK(modes.amplitude[k] == plucked.amplitude[k]);
      const long double turns = turns_of(plucked.phase[k]) + frequency_of(string, n) * time;
      // A million roundings of some 1e-16 turn, and the last bit of the frequency.
      CHECK(static_cast<double>(distance(turns_of(modes.phase[k]), turns)) <= 1e-9);
    }
  }
}

TEST_CASE("a phase that wraps a hundred million times is where it should be") {
  const std::int64_t ticks = scaled(100'000'000);
  const StringConstants string = make_string(65.4);
  ModalString modes;
  set_fundamental({1e-3, 0U}, 1, 0, modes);
  for (std::int64_t i = 0; i < ticks; ++i) advance_free_modes(string, 1.0, 20'000'000, modes);
  const long double turns =
      static_cast<long double>(string.frequency) * 20e-3L * static_cast<long double>(ticks);
  CHECK(static_cast<double>(distance(turns_of(modes.phase[0]), turns)) <= 1e-7);
}

TEST_CASE("partials are where inharmonicity and glide put them") {
  for (const double inharmonicity : {0.0, 1e-5, 1e-2, 0.1}) {
    for (const double pitch : {1.0, 1.047}) {
      const StringConstants string = make_string(130.8, inharmonicity);
      ModalString modes;
      pluck_modes(string, {0.3, 1e-3}, kMaxModes, modes);
      const ModalString before = modes;
      advance_free_modes(string, pitch, 3'000'000, modes);
      for (int n = 1; n <= kMaxModes; ++n) {
        const auto k = static_cast<std::size_t>(n - 1);
        const long double turns = frequency_of(string, n) * pitch * 3e-3L;
        CHECK(static_cast<double>(distance(turns_of(modes.phase[k] - before.phase[k]), turns)) <=
              1e-12);
      }
    }
  }
}

TEST_CASE("modes set from a fundamental have its energy") {
  SplitMix64 random(3);
  for (int i = 0; i < 1000; ++i) {
    const double frequency = random.uniform(20.0, 1000.0);
    const StringConstants string = make_string(frequency, random.uniform(0.0, 0.01));
    const Fundamental fundamental{random.uniform(0.0, 0.01), random.next()};
    const double energy = 0.5 * static_cast<double>(stiffness_of(string, 1)) *
                          fundamental.amplitude * fundamental.amplitude;
    ModalString modes;
    set_fundamental(fundamental, 32, 5, modes);
    CHECK(modes.count == 32);
    CHECK(modes.phase[0] == fundamental.phase);
    CHECK(modal_energy(string, modes, string.decay, 5) == doctest::Approx(energy).epsilon(1e-13));
  }
}

TEST_CASE("partials are relative to the strongest, and none where nothing rings") {
  const StringConstants string = make_string(65.4);
  std::array<float, kMaxModes> partials;
  partials.fill(7.0F);
  ModalString modes;
  CHECK(relative_partials(modes, partials) == 0);
  pluck_modes(string, {0.5}, 8, modes);
  CHECK(relative_partials(modes, partials) == 0);
  pluck_modes(string, {0.5, 3e-3}, 8, modes);
  CHECK(relative_partials(modes, partials) == 8);
  for (int n = 1; n <= kMaxModes; ++n) {
    const double expected = n > 8 || n % 2 == 0 ? 0.0 : 1.0 / (n * n);
    CHECK(static_cast<double>(partials[static_cast<std::size_t>(n - 1)]) ==
          doctest::Approx(expected).epsilon(1e-6));
  }
}

TEST_CASE("a string without tuning, slack or without length has no modes and stays finite") {
  for (int i = 0; i < 3; ++i) {
    StringParameters parameters;
    parameters.p_WB = {i == 2 ? 0.0 : 1.1, 0.0, 0.0};
    parameters.frequency = i == 0 ? 0.0 : 65.4;
    if (i == 1) parameters.tension = 0.0;
    const StringConstants string = derive_string(parameters);
    ModalString modes;
    pluck_modes(string, {0.3, 5e-3, 1e-3, 9}, 16, modes);
    CHECK(modes.count == 0);
    advance_free_modes(string, 1.0, 1'000'000, modes);
    CHECK(modal_energy(string, modes, 0.5, 1'000'000) == 0.0);
    CHECK(modal_displacement(modes, 0.3, 0.5, 1'000'000) == 0.0);
  }
}

}  // namespace
}  // namespace hapticd::test
