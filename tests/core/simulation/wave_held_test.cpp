// Strings that sound under fingers that hold them still. Truth: the static law, which another scene
// has alone.
#include <doctest/doctest.h>

#include <algorithm>

#include "core/math/elementary.h"
#include "tests/core/simulation/wave_scene.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// A finger that comes down on the string and stays.
struct Press {
  WaveScene scene;
  double lambda = 0.5;
  double depth = 5e-3;  ///< of the hand, m
  double speed = 0.1;   ///< m/s
  double aside = 0.0;   ///< of the string's axis, where it comes down, m
};

struct Held {
  Vector3 force;        ///< in the end, N
  double change = 0.0;  ///< largest from then on, N
  int tones = 0;
  double deflection = 0.0;
};

Held hold(const Press& press, bool sounds) {
  Instrument instrument = wave_instrument(press.scene, sounds);
  const double x = 1.1 * press.lambda;
  const double over = press.scene.reach();
  instrument.tick(Vector3(x, over + 2e-3, press.aside));
  instrument.glide(Vector3(x, over - press.depth, press.aside), press.speed,
                   [](const SimulationTick&) {});
  const Vector3 p = instrument.p_WH;
  for (int i = 0; i < 2000; ++i) instrument.tick(p);
  Held held;
  held.force = felt_force(instrument);
  for (int i = 0; i < 300; ++i) {
    instrument.tick(p);
    held.change = std::max(held.change, (felt_force(instrument) - held.force).norm());
  }
  held.tones = count(instrument.events, StringEventKind::kTone);
  if (const StringTick* row = instrument.reading(0)) {
    held.deflection = to_vector(row->deflection_W).norm();
  }
  return held;
}

Press random_press(SplitMix64& random) {
  Press press;
  press.scene.tension = std::pow(10.0, random.uniform(0.7, 2.2));
  press.scene.frequency = std::pow(10.0, random.uniform(1.6, 2.6));
  press.scene.axial_stiffness = random.chance(0.5) ? 0.0 : std::pow(10.0, random.uniform(3.0, 5.0));
  press.scene.kt = std::pow(10.0, random.uniform(2.3, 4.0));
  press.lambda = random.uniform(0.05, 0.95);
  press.scene.decay = 0.05;
  press.scene.tip = random.uniform(2e-3, 15e-3);
  // Deeper the finger would slip off: it pushes aside with N / s what holds it with N / depth.
  press.depth = random.uniform(0.05, 0.8) * press.scene.reach();
  press.speed = random.uniform(0.02, 0.6);
  return press;
}

TEST_CASE("a finger that holds a string still feels just the static law, and nothing moves") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  const std::int64_t presses = scaled(300);
  for (std::int64_t i = 0; i < presses; ++i) {
    const Press press = random_press(random);
    CAPTURE(press.scene.tension);
    CAPTURE(press.scene.frequency);
    CAPTURE(press.scene.axial_stiffness);
    CAPTURE(press.scene.kt);
    CAPTURE(press.lambda);
    CAPTURE(press.depth);
    CAPTURE(press.scene.tip);
    CAPTURE(press.speed);
    const Held still = hold(press, false);
    const Held held = hold(press, true);
    CHECK(held.change <= 1e-6);
    CHECK((held.force - still.force).norm() <= 1e-3 * still.force.norm() + 1e-6);
    CHECK(held.tones == 0);
  }
}

TEST_CASE("a finger that friction holds on a string aside of its middle feels a constant force") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  const std::int64_t presses = scaled(200);
  for (std::int64_t i = 0; i < presses; ++i) {
    Press press = random_press(random);
    press.scene.friction = 0.8;
    press.aside = random.uniform(-0.1, 0.1) * press.scene.reach();
    press.depth *= 0.5;
    // So slowly that the string does not bounce: where it sticks is a matter of the way there.
    press.speed = 0.005;
    CAPTURE(press.scene.tension);
    CAPTURE(press.scene.frequency);
    CAPTURE(press.scene.axial_stiffness);
    CAPTURE(press.scene.kt);
    CAPTURE(press.scene.tip);
    CAPTURE(press.lambda);
    CAPTURE(press.depth);
    CAPTURE(press.aside);
    CAPTURE(press.speed);
    const Held still = hold(press, false);
    const Held held = hold(press, true);
    CHECK(held.change <= 1e-6);
    CHECK((held.force - still.force).norm() <= 5e-2 * still.force.norm() + 1e-6);
    CHECK(held.tones == 0);
  }
}

TEST_CASE("a hand that trembles over a string without touching plays no tone") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  const std::int64_t hovers = scaled(20);
  for (std::int64_t i = 0; i < hovers; ++i) {
    Instrument instrument = wave_instrument({});
    const double over = felt_distance(instrument) + 0.1e-3;
    const double x = random.uniform(0.05, 1.05);
    const double tremor = random.uniform(6.0, 12.0);
    double bent = 0.0;
    for (int k = 0; k < 10000; ++k) {
      const double noise =
          20e-6 * (random.uniform() + random.uniform() + random.uniform() - 1.5) * 2.0;
      const double y = over + noise + 0.1e-3 * std::sin(2.0 * kPi * tremor * 1e-3 * k);
      instrument.tick(Vector3(x, y, 0.0));
      if (const StringTick* row = instrument.reading(0)) {
        bent = std::max(bent, to_vector(row->deflection_W).norm());
      }
    }
    CHECK(bent > 1e-6);
    CHECK(count(instrument.events, StringEventKind::kTone) == 0);
    CHECK(count(instrument.events, StringEventKind::kPress) == 0);
  }
}

}  // namespace
}  // namespace hapticd::test
