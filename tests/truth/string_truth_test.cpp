// The truth about strings judged before it judges: two methods against each other, energy, closed
// forms, convergence.
#include "tests/truth/string_truth.h"
#include "tests/support/within.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <limits>

namespace hapticd::test {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

double rms_percent(const TruthRun& run, const TruthRun& truth) {
  double error = 0.0;
  double size = 0.0;
  for (std::size_t i = 0; i < truth.force.size(); ++i) {
    error += (run.force[i] - truth.force[i]) * (run.force[i] - truth.force[i]);
    size += truth.force[i] * truth.force[i];
  }
  return 100.0 * std::sqrt(error / size);
}

TruthString undamped() {
  TruthString string;
  string.decay = kNever;
  string.touch_decay = kNever;
  return string;
}

double plucked_energy(const TruthString& string, const TruthPress& press) {
  const double lambda = press.pluck_lambda;
  return string.tension * press.pluck_delta * press.pluck_delta /
         (2.0 * string.length * lambda * (1.0 - lambda));
}

TEST_CASE("modes and d'Alembert's waves feel the same under a finger") {
  for (const TruthString& string : {TruthString{}, undamped()}) {
    for (const double pluck_lambda : {0.1, 0.5}) {
      TruthPress press;
      press.pluck_lambda = pluck_lambda;
      CHECK(rms_percent(play_modes(string, press, 256, 400'000), play_grid(string, press, 2000)) <=
            0.02);
    }
  }
}

TEST_CASE("more modes and more samples change the force less and less") {
  const TruthString string;
  TruthPress press;
  press.stiffness = 1e4;
  const TruthRun best = play_modes(string, press, 512, 1'600'000);
  const double modes_64 = rms_percent(play_modes(string, press, 64, 1'600'000), best);
  const double modes_256 = rms_percent(play_modes(string, press, 256, 1'600'000), best);
  CHECK(modes_256 <= 0.25 * modes_64);
  CHECK(modes_256 <= 0.02);
  const double rate_400 = rms_percent(play_modes(string, press, 512, 400'000), best);
  const double rate_800 = rms_percent(play_modes(string, press, 512, 800'000), best);
  CHECK(rate_800 <= 0.5 * rate_400);
  CHECK(rate_800 <= 0.01);
}

TEST_CASE("what the hand and the pluck put into an undamped string stays in it") {
  const TruthString string = undamped();
  const TruthPress press;
  const double plucked = plucked_energy(string, press);
  const TruthRun grid = play_grid(string, press, 2000);
  // 2000 cells round the corners of the triangle off, 256 modes leave 0.4 % of its energy out.
  CHECK(grid.energy_before == within(plucked, 0.003));
  CHECK(std::abs(grid.energy - grid.energy_before - grid.work) <= 1e-3 * plucked);
  const TruthRun modes = play_modes(string, press, 256, 400'000);
  CHECK(modes.energy_before == within(plucked, 0.006));
  CHECK(std::abs(modes.energy - modes.energy_before - modes.work) <= 1e-3 * plucked);
}

TEST_CASE("a string that a finger damps loses energy") {
  const TruthString string;
  TruthPress press;
  press.end_D = press.start_D;
  const TruthRun grid = play_grid(string, press, 1000);
  const TruthRun modes = play_modes(string, press, 256, 400'000);
  // exp(-2 t / T_d) over 100 ms, while the share of kinetic energy moves it by 1 / (omega T_d).
  CHECK(grid.energy / grid.energy_before == within(std::exp(-0.2 / 0.03), 0.1));
  CHECK(modes.energy / modes.energy_before == within(std::exp(-0.2 / 0.03), 0.1));
  for (const double force : grid.force) CHECK(force == 0.0);
  for (const double force : modes.force) CHECK(force == 0.0);
}

TEST_CASE("a string pressed for long rests where statics says") {
  const TruthString string;
  TruthPress press;
  press.ticks = 400;
  const double k0 = 30.0 / (1.1 * 0.3 * 0.7);
  const double force = 2e-3 / (1.0 / k0 + 1e-3);
  CHECK(play_modes(string, press, 256, 200'000).force.back() == within(force, 1e-4));
  CHECK(play_grid(string, press, 1000).force.back() == within(force, 1e-4));
}

TEST_CASE("a plucked string is a triangle that comes back every period, mirrored every half") {
  const TruthString string;
  for (const double lambda : {0.0, 0.05, 0.1, 0.6, 1.0}) {
    const double height = 5e-3 * (lambda <= 0.1 ? lambda / 0.1 : (1.0 - lambda) / 0.9);
    const double period = 1.0 / string.frequency;
    CHECK(std::abs(free_displacement(string, 0.1, 5e-3, lambda, 0.0) - height) <= 1e-17);
    CHECK(std::abs(free_displacement(string, 0.1, 5e-3, lambda, 7.0 * period) - height) <= 1e-15);
    CHECK(std::abs(free_displacement(string, 0.1, 5e-3, 1.0 - lambda, 3.5 * period) + height) <=
          1e-15);
  }
}

}  // namespace
}  // namespace hapticd::test
