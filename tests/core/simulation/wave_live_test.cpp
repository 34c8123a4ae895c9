// Settings that change under fingers that hold strings which sound. Truth: the static law, which
// another scene has alone, and sqrt(T / mu) / (2 L).
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "tests/core/simulation/wave_path.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

/// What changes while a finger holds the string, by factors.
struct Change {
  WaveScene scene;
  double lambda = 0.5;
  double depth = 5e-3;     ///< of the hand, m
  double tension = 1.0;    ///< the density stays
  double stiffness = 1.0;  ///< of coupling and contact
};

constexpr int kChangeTicks = 100;

WaveScene changed(const Change& change, double share) {
  WaveScene scene = change.scene;
  scene.tension *= std::pow(change.tension, share);
  scene.frequency *= std::pow(change.tension, 0.5 * share);
  scene.kt *= std::pow(change.stiffness, share);
  return scene;
}

void set(const WaveScene& scene, Instrument& instrument) {
  const Capsule& axis = instrument.capsules_W.front();
  StringParameters string = scene.string();
  string.p_WA = to_array(axis.p_A);
  string.p_WB = to_array(axis.p_B);
  instrument.strings.front() = derive_string(string);
  instrument.scene().stiffness.kt = scene.kt;
}

/// Force in every tick from when the finger has held for a second until one second after the
/// change.
std::vector<Vector3> hold_through(const Change& change, bool sounds, int& tones) {
  Instrument instrument = wave_instrument(change.scene, sounds);
  const double x = kWaveLength * change.lambda;
  const double over = change.scene.reach();
  instrument.tick(Vector3(x, over + 2e-3, 0.0));
  instrument.glide(Vector3(x, over - change.depth, 0.0), 0.1, [](const SimulationTick&) {});
  const Vector3 p = instrument.p_WH;
  for (int i = 0; i < 1000; ++i) instrument.tick(p);
  std::vector<Vector3> forces;
  for (int i = 1; i <= kChangeTicks + 1000; ++i) {
    if (i <= kChangeTicks) {
      set(changed(change, static_cast<double>(i) / kChangeTicks), instrument);
    }
    instrument.tick(p);
    forces.push_back(felt_force(instrument));
  }
  tones = count(instrument.events, StringEventKind::kTone);
  return forces;
}

TEST_CASE("a finger that holds a string while it is tuned or softened feels the static law") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  const std::int64_t changes = scaled(60);
  for (std::int64_t i = 0; i < changes; ++i) {
    Change change;
    change.scene.tension = std::pow(10.0, random.uniform(1.0, 2.0));
    change.scene.frequency = std::pow(10.0, random.uniform(1.7, 2.3));
    change.scene.axial_stiffness =
        random.chance(0.5) ? 0.0 : std::pow(10.0, random.uniform(3.0, 4.5));
    change.scene.kt = std::pow(10.0, random.uniform(2.5, 3.5));
    change.scene.decay = 0.1;
    change.lambda = random.uniform(0.1, 0.9);
    change.depth = random.uniform(0.1, 0.6) * change.scene.reach();
    change.tension = std::pow(2.0, random.uniform(-1.0, 1.0));
    change.stiffness = random.chance(0.5) ? 1.0 : std::pow(3.0, random.uniform(-1.0, 1.0));
    CAPTURE(change.scene.tension);
    CAPTURE(change.scene.frequency);
    CAPTURE(change.scene.axial_stiffness);
    CAPTURE(change.scene.kt);
    CAPTURE(change.lambda);
    CAPTURE(change.depth);
    CAPTURE(change.tension);
    CAPTURE(change.stiffness);
    int tones = 0;
    const std::vector<Vector3> law = hold_through(change, false, tones);
    const std::vector<Vector3> felt = hold_through(change, true, tones);
    double apart = 0.0;
    for (std::size_t k = 0; k < law.size(); ++k) {
      apart = std::max(apart, (felt[k] - law[k]).norm() / law[k].norm());
    }
    CHECK(apart <= 0.1);
    CHECK((felt.back() - law.back()).norm() <= 1e-3 * law.back().norm() + 1e-6);
    CHECK(tones == 0);
  }
}

TEST_CASE("a string that rings follows its peg") {
  for (const double raise : {0.7, 1.0, 1.3, 2.0}) {
    CAPTURE(raise);
    Change change;
    change.scene.frequency = 110.0;
    change.scene.decay = 5.0;
    change.tension = raise;
    Instrument instrument = wave_instrument(change.scene);
    for (int k = 0; k <= 40; ++k) {
      instrument.tick(Vector3(0.3 * kWaveLength, 3e-3, 1e-3 * k - 12e-3));
    }
    const Vector3 away = instrument.p_WH;
    for (int i = 1; i <= kChangeTicks; ++i) {
      set(changed(change, static_cast<double>(i) / kChangeTicks), instrument);
      instrument.tick(away);
    }
    const auto& state = instrument.simulation().memory().waves.front().state;
    const double expected = 110.0 * std::sqrt(raise);
    // A finger that comes near has it stepped, and read in every tick.
    std::vector<double> swing;
    for (int i = 0; i < 1600; ++i) {
      instrument.tick(Vector3(0.3 * kWaveLength, change.scene.reach() + 6e-3, 0.0));
      swing.push_back(state.string.motion.qy[0] + state.string.motion.qz[0]);
    }
    const double heard = frequency(std::span(swing).subspan(100), 1e-3, expected);
    CHECK(std::abs(1200.0 * std::log2(heard / expected)) <= 1.0);
    CHECK(state.sounding.frequency == within(expected, 2e-3));
    CHECK(count(instrument.events, StringEventKind::kTone) == 1);
  }
}

}  // namespace
}  // namespace hapticd::test
