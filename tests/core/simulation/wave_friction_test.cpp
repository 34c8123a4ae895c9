// Friction of a finger on a string that sounds: within the cone it holds for as long as the hand
// does, and it slips at atan(mu). Truth: Coulomb's law, with the normal from where the finger is
// and where its force bends the string to.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"
#include "tests/core/simulation/wave_path.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// A finger that rubs a string without stretch.
struct Rubbing {
  WaveScene scene;
  double lambda = 0.5;
  double depth = 2e-3;  ///< of the hand, m
};

Rubbing random_rubbing(SplitMix64& random) {
  Rubbing rubbing;
  rubbing.scene.tension = random.uniform(20.0, 80.0);
  rubbing.scene.frequency = random.uniform(60.0, 300.0);
  rubbing.scene.decay = random.uniform(0.1, 0.3);
  rubbing.scene.kt = random.uniform(300.0, 3000.0);
  rubbing.scene.friction = random.uniform(0.1, 0.8);
  rubbing.lambda = random.uniform(0.2, 0.8);
  rubbing.depth = random.uniform(0.5e-3, 2.5e-3);
  return rubbing;
}

/// A finger that has come down, and waits until nothing swings.
Instrument pressed(const Rubbing& rubbing) {
  Instrument instrument = wave_instrument(rubbing.scene);
  instrument.scene().stiffness.length = 10.0;  // it slides, and does not roll
  const double x = kWaveLength * rubbing.lambda;
  instrument.tick(Vector3(x, rubbing.scene.reach() + 2e-3, 0.0));
  const auto nothing = [](const SimulationTick&) {};
  instrument.glide(Vector3(x, rubbing.scene.reach() - rubbing.depth, 0.0), 0.05, nothing);
  for (int k = 0; k < 1000; ++k) instrument.tick(instrument.p_WH);
  return instrument;
}

/// Angle between the force on the finger and the normal from the string to it, rad. The string lies
/// along x, and bends by its force as two straight legs do.
double angle(const Rubbing& rubbing, const Instrument& instrument) {
  const Vector3 force = felt_force(instrument);
  const Vector3& p_WG = instrument.output().tool(0).X_WG.p;
  const double left = p_WG.x();
  const double right = kWaveLength - left;
  // Its pull along x is friction's alone.
  const double yields = left * right / kWaveLength / rubbing.scene.tension;
  const Vector3 vertex(p_WG.x(), -yields * force.y(), -yields * force.z());
  const Vector3 along =
      ((Vector3(kWaveLength, 0.0, 0.0) - vertex).normalized() + vertex.normalized()).normalized();
  Vector3 normal = p_WG - vertex;
  normal = (normal - along * along.dot(normal)).normalized();
  return std::acos(std::clamp(force.normalized().dot(normal), -1.0, 1.0));
}

TEST_CASE("a finger within the cone holds a string that sounds for ten minutes, to 1 uN") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int i = 0; i < 4; ++i) {
    Rubbing rubbing = random_rubbing(random);
    rubbing.scene.friction = random.uniform(0.3, 0.8);
    CAPTURE(rubbing.scene.friction);
    CAPTURE(rubbing.lambda);
    Instrument instrument = pressed(rubbing);
    const double press = felt_force(instrument).y();
    // Aside until friction bears half of what it may.
    const double turn = random.uniform(0.0, 2.0 * kPi);
    const Vector3 way(std::cos(turn), 0.0, std::sin(turn));
    const double aside = 0.5 * rubbing.scene.friction * press / rubbing.scene.kt;
    const auto nothing = [](const SimulationTick&) {};
    instrument.glide(instrument.p_WH + aside * way, 0.02, nothing);
    for (int k = 0; k < 5000; ++k) instrument.tick(instrument.p_WH);
    const Vector3 held = felt_force(instrument);
    double most = 0.0;
    const std::int64_t ticks = scaled(600'000);
    for (std::int64_t k = 0; k < ticks; ++k) {
      instrument.tick(instrument.p_WH);
      most = std::max(most, (felt_force(instrument) - held).norm());
    }
    CAPTURE(held.x());
    CAPTURE(held.y());
    CAPTURE(held.z());
    CHECK(most <= 1e-6);
  }
}

TEST_CASE("a finger slips along a string that sounds at atan(mu)") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  const std::int64_t runs = scaled(100);
  for (std::int64_t i = 0; i < runs; ++i) {
    const Rubbing rubbing = random_rubbing(random);
    CAPTURE(rubbing.scene.friction);
    CAPTURE(rubbing.scene.tension);
    CAPTURE(rubbing.scene.kt);
    CAPTURE(rubbing.lambda);
    CAPTURE(rubbing.depth);
    Instrument instrument = pressed(rubbing);
    const double ahead = rubbing.lambda < 0.5 ? 1.0 : -1.0;
    const double due = std::atan(rubbing.scene.friction);
    double largest = 0.0;
    const auto look = [&](const SimulationTick&) {
      largest = std::max(largest, angle(rubbing, instrument));
    };
    instrument.glide(instrument.p_WH + Vector3(ahead * 20e-3, 0.0, 0.0), 5e-3, look);
    CHECK(std::abs(largest - due) <= 0.02 * due);
    CHECK(std::abs(angle(rubbing, instrument) - due) <= 0.02 * due);
  }
}

}  // namespace
}  // namespace hapticd::test
