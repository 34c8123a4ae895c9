// Truth: the closed solutions of a mass with damping, with a spring, and with dry friction.
#include "device/simulated/axis_response.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr double kDt = 5e-5;

/// One axis with its target at rest at 0.
struct Mass {
  AxisResponse response;
  double x = 0.0;
  double v = 0.0;

  explicit Mass(const AxisPlant& plant) : response(make_axis_response(plant, kDt)) {}
  void go(int steps, double force) {
    for (int i = 0; i < steps; ++i) {
      const AxisStep step = advance_axis(response, {x, v, 0.0}, force);
      x += step.moved;
      v = step.v;
    }
  }
};

double relative(double value, double truth) { return std::abs(value - truth) / std::abs(truth); }

}  // namespace

TEST_CASE("a damped mass under a constant force moves as the exponential solution says") {
  const double m = 0.159;
  const double b = 1.3;
  const double f = 2.5;
  Mass mass({.mass = m, .damping = b});
  for (const int steps : {1, 10, 1000, 20000}) {
    mass = Mass({.mass = m, .damping = b});
    mass.go(steps, f);
    const double t = steps * kDt;
    const double tau = m / b;
    CHECK(relative(mass.v, -f / b * std::expm1(-t / tau)) < 1e-11);
    // x = f/b (t + tau expm1(-t/tau)), which cancels at small t: the series there.
    const double x = t > 0.01
                         ? f / b * (t + tau * std::expm1(-t / tau))
                         : f / m * t * t * (1.0 / 2 - t / (6 * tau) + t * t / (24 * tau * tau));
    CHECK(relative(mass.x, x) < (t > 0.01 ? 1e-10 : 1e-8));
  }
}

TEST_CASE("without damping a constant force gives the parabola") {
  Mass mass({.mass = 0.2});
  mass.go(2000, 3.0);
  CHECK(relative(mass.v, 3.0 / 0.2 * 0.1) < 1e-12);
  CHECK(relative(mass.x, 0.5 * 3.0 / 0.2 * 0.01) < 1e-12);
}

TEST_CASE("held by a spring and damper it swings as the damped oscillator does") {
  const double m = 0.25;
  const double c = 6.0;
  const double k = 400.0;
  Mass mass({.mass = m, .damping = 1.0, .arm_damping = c - 1.0, .stiffness = k});
  const double decay = c / (2 * m);
  const double omega = std::sqrt(k / m - decay * decay);
  for (int i = 1; i <= 20; ++i) {
    mass.go(200, 2.0);
    const double t = i * 200 * kDt;
    const double x =
        2.0 / k *
        (1 - std::exp(-decay * t) * (std::cos(omega * t) + decay / omega * std::sin(omega * t)));
    CHECK(std::abs(mass.x - x) < 1e-13);
  }
}

TEST_CASE("a moving target drags the mass behind by damping to the ground over stiffness") {
  const double b = 1.5;
  const double k = 300.0;
  const double speed = 0.2;
  const AxisResponse response =
      make_axis_response({.mass = 0.2, .damping = b, .arm_damping = 8.0, .stiffness = k}, kDt);
  double y = 0.0;
  double v = 0.0;
  for (int i = 0; i < 40000; ++i) {
    const AxisStep step = advance_axis(response, {y, v, speed}, 0.0);
    y += step.moved - speed * kDt;
    v = step.v;
  }
  CHECK(relative(v, speed) < 1e-10);
  CHECK(relative(y, -b * speed / k) < 1e-9);
}

TEST_CASE("dry friction stops a sliding mass after m v^2 / 2 f, and there it stays") {
  const double m = 0.159;
  const double friction = 0.2;
  Mass mass({.mass = m, .coulomb = friction});
  mass.v = 0.1234;
  const double way = m * mass.v * mass.v / (2 * friction);
  const double time = m * mass.v / friction;
  mass.go(static_cast<int>(time / kDt) - 1, 0.0);
  CHECK(mass.v > 0.0);
  mass.go(3, 0.0);
  CHECK(mass.v == 0.0);
  // The last sub-step errs by at most its own way.
  CHECK(std::abs(mass.x - way) < friction / m * kDt * kDt);
  const double rest = mass.x;
  mass.go(1000, 0.0);
  CHECK(mass.x == rest);
}

TEST_CASE("a mass at rest sticks under any force below friction and slides with the rest above") {
  Mass mass({.mass = 0.1, .damping = 0.0, .coulomb = 0.5});
  for (const double force : {0.1, -0.3, 0.499, -0.4999}) {
    mass.go(500, force);
    CHECK(mass.v == 0.0);
    CHECK(std::abs(mass.x) < 1e-17);
  }
  mass.go(2000, 0.7);
  CHECK(relative(mass.v, 0.2 / 0.1 * 0.1) < 1e-10);
}

TEST_CASE("no chatter: a sticking mass on a spring keeps its place and never changes direction") {
  Mass mass({.mass = 0.1, .damping = 1.0, .stiffness = 2000.0, .coulomb = 0.5});
  mass.x = 0.01;
  int turns = 0;
  double last = 0.0;
  for (int i = 0; i < 40000; ++i) {
    mass.go(1, 0.0);
    if (mass.v * last < 0.0) ++turns;
    if (mass.v != 0.0) last = mass.v;
  }
  CHECK(mass.v == 0.0);
  // Amplitude falls by 2 f / k with each half swing: 20 of them at most, fewer with damping.
  CHECK(turns <= 20);
  CHECK(std::abs(mass.x) <= 0.5 / 2000.0 * (1 + 1e-9));
}

TEST_CASE("left alone, energy never grows, whatever the mass, damping, stiffness and friction") {
  SplitMix64 random(11);
  for (std::int64_t i = 0; i < scaled(20'000); ++i) {
    const auto decades = [&](double low, double high) {
      return std::pow(10.0, random.uniform(low, high));
    };
    const AxisPlant plant{.mass = decades(-9, 2),
                          .damping = random.chance(0.2) ? 0.0 : decades(-6, 3),
                          .arm_damping = random.chance(0.2) ? 0.0 : decades(-6, 4),
                          .stiffness = random.chance(0.2) ? 0.0 : decades(-3, 5),
                          .coulomb = random.chance(0.5) ? 0.0 : decades(-4, 2)};
    Mass mass(plant);
    mass.x = random.uniform(-1.0, 1.0);
    mass.v = random.uniform(-3.0, 3.0);
    const auto energy = [&] {
      return 0.5 * plant.mass * mass.v * mass.v + 0.5 * plant.stiffness * mass.x * mass.x;
    };
    double before = energy();
    for (int step = 0; step < 50; ++step) {
      const double speed = std::abs(mass.v);
      mass.go(1, 0.0);
      const double after = energy();
      CAPTURE(plant.mass);
      CAPTURE(plant.stiffness);
      CAPTURE(plant.coulomb);
      // Friction within the sub-step in which a mass turns may be off by its own work.
      const double slack = plant.coulomb * (speed + std::abs(mass.v)) * kDt;
      REQUIRE(after <= before * (1 + 1e-12) + slack);
      before = after;
    }
  }
}

}  // namespace hapticd::test
