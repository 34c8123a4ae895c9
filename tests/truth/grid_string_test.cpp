// The grid of a touched string judged before it judges: closed forms, energy, convergence, and the
// figures of another calculation.
#include "tests/truth/grid_string.h"
#include "tests/support/within.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "tests/support/scale.h"
#include "tests/truth/played_string.h"

namespace hapticd::test {
namespace {

/// As many of `all` as there is time for: one under a sanitizer.
template <typename T>
std::vector<T> some(std::vector<T> all) {
  const auto most = static_cast<std::size_t>(scaled(10 * static_cast<std::int64_t>(all.size())));
  if (most < all.size()) all.resize(most);
  return all;
}

constexpr double kPi = std::numbers::pi;

GridString lossless() {
  GridString string;
  string.loss = 0.0;
  string.loss_n2 = 0.0;
  return string;
}

TEST_CASE("every partial of a free string has the pitch and the decay of its closed form") {
  GridString string;
  string.inharmonicity = 1e-3;
  string.loss = 3.0;
  string.loss_n2 = 0.02;
  const int cells = 500;
  for (const int n : some(std::vector{2, 1, 6})) {
    StringGrid grid(string, cells);
    std::vector<Across> shape;
    for (int j = 0; j <= cells; ++j) {
      shape.emplace_back(1e-3 * std::sin(n * kPi * j / cells),
                         -2e-3 * std::sin(n * kPi * j / cells));
    }
    grid.let_go(shape);
    const double B = string.inharmonicity;
    const double f = n * string.frequency * std::sqrt((1.0 + B * n * n) / (1.0 + B));
    std::vector<double> swing;
    while (grid.time() < 0.5) {
      grid.step({});
      swing.push_back(grid.displacement(0.5 / n).x());
    }
    CHECK(frequency(swing, grid.step_s(), f) == within(f, 1e-4));
    const StringGrid::Mode mode = grid.mode(n, 2.0 * kPi * f);
    const double left = std::exp(-(string.loss + n * n * string.loss_n2) * grid.time());
    CHECK(std::hypot(mode.q.x(), mode.v.x()) == within(1e-3 * left, 3e-3));
    CHECK(std::hypot(mode.q.y(), mode.v.y()) == within(2e-3 * left, 3e-3));
  }
}

TEST_CASE("a finger that holds a string still bears what statics says") {
  const std::uint64_t seed = std::random_device{}();
  CAPTURE(seed);
  std::mt19937_64 random(seed);
  for (std::int64_t i = scaled(80); i > 0; --i) {
    const auto in = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    GridString string;
    string.tension = in(10.0, 100.0);
    string.axial_stiffness = in(0.0, 5e3);
    string.loss = 100.0;
    GridFinger finger;
    finger.stiffness = in(500.0, 2e4);
    // Between two cells a contact is up to 0.7 % stiffer.
    const double lambda = std::round(400.0 * in(0.1, 0.9)) / 400.0;
    const double depth = in(1e-3, 1e-2);
    CAPTURE(string.tension);
    CAPTURE(string.axial_stiffness);
    CAPTURE(lambda);
    StringGrid grid(string, 400);
    grid.add(finger);
    const FingerPath path = [&](double time) {
      return FingerPlace{lambda, {0.0, finger.radius - depth * std::min(1.0, time / 0.05)}};
    };
    play(grid, {&path, 1}, 0.3);
    const double deflection = grid.displacement(lambda).norm();
    CHECK(grid.finger(0).normal == within(finger.stiffness * (depth - deflection), 1e-6));
    CHECK(grid.finger(0).normal == within(held_force(string, lambda, deflection), 5e-3));
  }
}

/// What of the energy is not accounted for, over all that was put in, in 60 ms of random playing.
double unaccounted(std::uint64_t seed, int cells) {
  std::mt19937_64 random(seed);
  const auto in = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  GridString string = lossless();
  string.inharmonicity = in(0.0, 1e-4);
  string.axial_stiffness = in(0.0, 2e3);
  StringGrid grid(string, cells);
  GridFinger finger;
  finger.stiffness = in(500.0, 5e3);
  grid.add(finger);
  GridPlane fret;
  fret.lambda = in(0.5, 0.7);
  fret.offset = -1e-3;
  fret.stiffness = 1e4;
  grid.add(fret);
  const double from = in(0.2, 0.4);
  const double to = in(0.2, 0.4);
  const double aside = in(-1e-3, 1e-3);
  const FingerPath path = [&](double time) {
    const double s = time / 0.06;
    return FingerPlace{from + (to - from) * s,
                       {aside, finger.radius - 4e-3 * std::sin(2.0 * kPi * s)}};
  };
  double most = 0.0;
  double worst = 0.0;
  play(grid, {&path, 1}, 0.06, [&] {
    most = std::max(most, grid.work());
    worst = std::max(worst, std::abs(grid.energy() + grid.contact_energy() - grid.work()));
  });
  return worst / most;
}

TEST_CASE("what the hand puts in stays in a string without losses, the better the finer") {
  for (std::int64_t i = scaled(40); i > 0; --i) {
    const std::uint64_t seed = std::random_device{}();
    CAPTURE(seed);
    const double coarse = unaccounted(seed, 100);
    const double fine = unaccounted(seed, 600);
    CHECK(fine <= 0.02);
    CHECK(fine <= 0.5 * coarse);
  }
}

TEST_CASE("friction never exceeds Coulomb's cone, and only takes") {
  GridString string = lossless();
  GridFinger finger;
  finger.friction = 0.4;
  StringGrid grid(string, 400);
  grid.add(finger);
  bool stuck = false;
  bool slipped = false;
  const FingerPath path = [&](double time) {
    return FingerPlace{0.3, {2e-2 * time, finger.radius - std::min(4e-3, 0.1 * time)}};
  };
  play(grid, {&path, 1}, 0.4, [&] {
    const GridTouch& touch = grid.finger(0);
    const double tangential =
        std::sqrt(std::max(0.0, touch.force.squaredNorm() - touch.normal * touch.normal));
    CHECK(tangential <= 0.4 * touch.normal * (1.0 + 1e-9) + 1e-12);
    if (touch.normal > 0.05) {
      stuck = stuck || tangential < 0.3 * touch.normal;
      slipped = slipped || tangential > 0.3999 * touch.normal;
    }
    CHECK(grid.energy() + grid.contact_energy() <= grid.work() + 1e-3 * grid.work() + 1e-8);
  });
  CHECK(stuck);
  CHECK(slipped);
}

// By 48 modes in two planes at 100 kHz, another program.
TEST_CASE("plucks are as loud as another calculation found them") {
  GridString string = lossless();
  string.frequency = 146.8;
  const std::vector<std::array<double, 2>> speed_and_level_mm{
      {0.45, 0.220}, {0.5, 0.356}, {0.6, 0.158}, {0.7, 0.436}, {0.8, 1.004},
      {0.9, 1.479},  {1.0, 1.830}, {1.2, 2.184}, {1.5, 2.280}};
  for (const auto& [speed, level_mm] : some(speed_and_level_mm)) {
    const GridTone tone =
        pluck(string, {.lambda = 0.1, .speed = speed, .height = 3e-3, .finger = {}}, 1100);
    CHECK(std::abs(20.0 * std::log10(1e3 * tone.amplitude / level_mm)) <= 0.03);
  }
}

double cents(double f, double of) { return 1200.0 * std::log2(f / of); }

TEST_CASE("a string on a fret sounds from there, one in the air as flat as the finger is soft") {
  GridString string;
  string.length = 0.648;
  string.tension = 70.0;
  string.frequency = 110.0;
  for (const double axial_stiffness : some(std::vector{5e3, 0.0})) {
    string.axial_stiffness = axial_stiffness;
    GridFret fret;
    const GridStop on_fret = stop_at_fret(string, fret, 324);
    const double tighter = std::sqrt(on_fret.tension / string.tension);
    CHECK(std::abs(cents(on_fret.frequency, 110.0 * 0.648 / 0.424 * tighter)) <= 1.0);
    CHECK(on_fret.fret_force > 0.0);
    fret.below = std::numeric_limits<double>::infinity();
    const GridStop in_air = stop_at_fret(string, fret, 324);
    const double sounding = 110.0 * 0.648 / 0.474 * std::sqrt(in_air.tension / string.tension);
    // The bristle of 20 kN/m lets the end of what sounds give way, as if it were longer by T / k.
    const double flat = 1200.0 * std::log2(1.0 - string.tension / 2e4 / 0.474);
    CHECK(std::abs(cents(in_air.frequency, sounding) - flat) <= 2.0);
  }
}

TEST_CASE("a string touched lightly at a node sounds its harmonic when the finger is gone") {
  for (const int part : some(std::vector{3, 2, 4})) {
    CAPTURE(part);
    GridHarmonic harmonic;
    harmonic.part = part;
    harmonic.force = 25e-3;
    const GridPartials partials = touch_harmonic(GridString{}, harmonic, 440);
    CHECK(std::abs(cents(partials.frequency, part * 65.4)) <= 0.1);
    CHECK(partials.others <= -20.0);
  }
}

}  // namespace
}  // namespace hapticd::test
