// The tank gives no more than it holds to any hand whose acceleration is bounded.
#include "core/instrument/energy_tank.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

TEST_CASE("a force within the tank's means is left as it is and held") {
  EnergyTank tank{1.0, 1.0, 0.0};
  CHECK(draw_from_tank(2.0, hand_reach(0.1, 500.0, 1e-3), tank) == 2.0);
  CHECK(tank.held_force == 2.0);
  CHECK(draw_from_tank(-3.0, hand_reach(-0.1, 500.0, 1e-3), tank) == -3.0);
  CHECK(tank.held_force == -3.0);
  CHECK(tank.energy == 1.0);
}

TEST_CASE("a force beyond the tank's means becomes (E + 50 uJ) / ((v + a dt) dt), with its sign") {
  for (const double sign : {1.0, -1.0}) {
    for (const double speed : {0.3, -0.3}) {
      EnergyTank tank{1e-4, 1e-4, 0.0};
      const double bound = 1.5e-4 / ((speed + 500.0 * 1e-3) * 1e-3);
      const double force = draw_from_tank(sign * 50.0, hand_reach(speed, 500.0, 1e-3), tank);
      CHECK(force == within(sign * bound, 1e-14));
      CHECK(tank.held_force == force);
    }
  }
}

TEST_CASE("a tank whose reserve is spent gives no force, however slow the hand") {
  EnergyTank tank{1.0, -50e-6, 0.0};
  CHECK(draw_from_tank(1.0, hand_reach(0.0, 500.0, 1e-3), tank) == 0.0);
  CHECK(draw_from_tank(-1.0, hand_reach(10.0, 500.0, 1e-3), tank) == 0.0);
}

TEST_CASE("work given leaves the tank, work of the hand comes back until it is full") {
  EnergyTank tank{1.0, 1.0, 2.0};
  settle_tank(0.25, tank);
  CHECK(tank.energy == 0.5);
  settle_tank(-0.1, tank);
  CHECK(tank.energy == within(0.7, 1e-15));
  settle_tank(-5.0, tank);
  CHECK(tank.energy == 1.0);
  settle_tank(5.0, tank);
  CHECK(tank.energy == -50e-6);
}

TEST_CASE("no hand of bounded acceleration gets more out of a tank than was in it and 50 uJ") {
  SplitMix64 random(21);
  const std::int64_t runs = scaled(20'000);
  double worst = 0.0;
  for (std::int64_t run = 0; run < runs; ++run) {
    const double limit = std::exp2(random.uniform(0.0, 12.0));
    EnergyTank tank{1.0, 1.0, 0.0};
    double speed = random.uniform(-2.0, 2.0);
    double given = 0.0;
    for (int k = 0; k < 100; ++k) {
      const double dt = random.uniform(0.25e-3, 5e-3);
      const double wanted = random.chance(0.5) ? 1e4 : -1e4;
      const double along = wanted > 0.0 ? speed : -speed;
      const double force =
          draw_from_tank(wanted * random.uniform(), hand_reach(along, limit, dt), tank);
      // The hand follows the force as hard as it can.
      const double acceleration = force > 0.0 ? limit : -limit;
      const double moved = speed * dt + 0.5 * acceleration * dt * dt;
      speed = std::clamp(speed + acceleration * dt, -10.0, 10.0);
      given += force * moved;
      settle_tank(moved, tank);
      worst = std::max(worst, given);
    }
  }
  CHECK(worst <= 1.0 + 50e-6 + 1e-12);
  CHECK(worst > 0.9);
}

}  // namespace
}  // namespace hapticd::test
