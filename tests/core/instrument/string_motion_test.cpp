// Modes turned sub-step by sub-step, against closed forms by libm.
#include "core/instrument/string_motion.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/random.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

StringConstants constants(double frequency, double inharmonicity = 0.0) {
  StringParameters string;
  string.p_WB = {1.1, 0.0, 0.0};
  string.frequency = frequency;
  string.inharmonicity = inharmonicity;
  return derive_string(string);
}

TEST_CASE("every mode of a free string swings and decays as its closed form, a second long") {
  const StringConstants string = constants(65.4, 1e-4);
  const StringLoss loss{0.8, 0.01};
  const ModeTable table = mode_table(string, loss, 32);
  REQUIRE(table.count == 32);
  ModalMotion motion;
  motion.qy.fill(1e-3);
  motion.vz.fill(2e-3);
  for (int step = 0; step < 1000 * kSubSteps; ++step) turn(table, PerMode{}, motion);
  for (int n = 1; n <= table.count; ++n) {
    CAPTURE(n);
    const auto i = static_cast<std::size_t>(n - 1);
    const double omega = kTurn * n * 65.4 * std::sqrt((1.0 + 1e-4 * n * n) / (1.0 + 1e-4));
    const double sigma = 1.0 / 0.8 + 0.01 * n * n;
    const double damped = std::sqrt(omega * omega - sigma * sigma);
    const double left = std::exp(-sigma);
    // q(0) = 1 mm at rest, and q(0) = 0 at a speed of 2 mm omega.
    const double at_rest = left * (std::cos(damped) + sigma / damped * std::sin(damped));
    const double struck = left * omega / damped * std::sin(damped);
    CHECK(std::abs(motion.qy[i] - 1e-3 * at_rest) <= 1e-12);
    CHECK(std::abs(motion.qz[i] - 2e-3 * struck) <= 1e-12);
  }
}

TEST_CASE("a constant force brings a string to where statics says, with what the modes leave out") {
  const StringConstants string = constants(146.8);
  const ModeTable table = mode_table(string, {0.05, 0.0}, 32);
  for (const double lambda : {0.02, 0.1, 0.37, 0.5, 0.9}) {
    PerMode shapes{};
    mode_shapes(table, lambda, shapes);
    ModalMotion motion;
    for (int step = 0; step < 2 * 1000 * kSubSteps; ++step) {
      turn(table, PerMode{}, motion);
      push(table, shapes, {0.3, -0.7}, motion);
    }
    const Transverse u = displacement(table, motion, shapes);
    const double rest = residual_compliance(string, table, lambda, shapes);
    const double compliance = lambda * (1.0 - lambda) * 1.1 / 30.0;
    CHECK(u.y + 0.3 * rest == within(0.3 * compliance, 1e-9));
    CHECK(u.z - 0.7 * rest == within(-0.7 * compliance, 1e-9));
  }
}

TEST_CASE("shapes are sines wherever a string is touched") {
  const ModeTable table = mode_table(constants(65.4), {}, kMaxModes);
  REQUIRE(table.count == kMaxModes);
  const std::uint64_t seed = std::random_device{}();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int i = 0; i < 1000; ++i) {
    const double lambda = i == 0 ? 0.0 : i == 1 ? 1.0 : random.uniform();
    PerMode shapes{};
    mode_shapes(table, lambda, shapes);
    for (int n = 1; n <= table.count; ++n) {
      const auto truth = static_cast<double>(
          std::sin(static_cast<long double>(n) * std::numbers::pi_v<long double> * lambda));
      CHECK(std::abs(shapes[static_cast<std::size_t>(n - 1)] - truth) <= 1e-12);
    }
  }
}

TEST_CASE(
    "a string keeps as many modes as turn by a quarter in a sub-step, and none without pitch") {
  CHECK(mode_table(constants(65.4), {}, 32).count == 32);
  CHECK(mode_table(constants(65.4), {}, 30).count == 28);
  CHECK(mode_table(constants(146.8), {}, 64).count == 52);
  CHECK(mode_table(constants(2000.0), {}, 32).count == 4);
  CHECK(mode_table(constants(2001.0), {}, 32).count == 0);
  CHECK(mode_table(constants(0.0), {}, 32).count == 0);
}

}  // namespace
}  // namespace hapticd::test
