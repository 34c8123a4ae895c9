// Strings that sound, played by a tool through the whole tick, against finite differences of the
// string and of what holds the tool.
#include <doctest/doctest.h>

#include <cmath>

#include "core/math/elementary.h"
#include "tests/core/simulation/wave_scene.h"
#include "tests/truth/played_string.h"

namespace hapticd::test {
namespace {

StringParameters plucked_string(double frequency) {
  StringParameters string;
  string.tension = 30.0;
  string.frequency = frequency;
  string.youngs_modulus = 0.0;
  string.decay = 1000.0;
  return string;
}

/// What a pluck through the tick leaves.
struct Pluck {
  int tones = 0;
  StringEvent tone;
  double energy = 0.0;
};

Pluck pluck_with(const GridPluck& way, const StringParameters& string) {
  Instrument instrument(1, string, wave_options());
  const double x = 1.1 * way.lambda;
  for (double z = -12e-3; z < 60e-3; z += 1e-3 * way.speed) {
    instrument.tick(Vector3(x, way.height, z));
  }
  for (int i = 0; i < 20; ++i) instrument.tick(instrument.p_WH);
  Pluck left;
  for (const StringEvent& event : instrument.events) {
    if (event.kind != StringEventKind::kTone) continue;
    ++left.tones;
    left.tone = event;
  }
  const StringTick* row = instrument.reading(0);
  left.energy = row == nullptr ? 0.0 : row->energy;
  return left;
}

double decibels(double energy, double other) { return 10.0 * std::log10(energy / other); }

TEST_CASE("plucks through the tick leave the energy that finite differences find, at any speed") {
  for (const double frequency : {65.4, 146.8}) {
    for (const double lambda : {0.1, 0.25, 0.5}) {
      for (const double speed : {0.45, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.5}) {
        CAPTURE(frequency);
        CAPTURE(lambda);
        CAPTURE(speed);
        const GridPluck way{.lambda = lambda, .speed = speed, .height = 3e-3, .finger = {}};
        GridString grid;
        grid.frequency = frequency;
        grid.loss = 0.001;
        grid.loss_n2 = 0.002;
        const GridTone truth = pluck(grid, way, 1100);
        const Pluck played = pluck_with(way, plucked_string(frequency));
        CHECK(std::abs(decibels(played.energy, truth.energy)) <= 0.1);
        REQUIRE(played.tones == 1);
        // The tone's amplitude is that of a fundamental with the same energy.
        const double amplitude = std::sqrt(4.0 * 1.1 * truth.energy / (kPi * kPi * 30.0));
        CHECK(std::abs(decibels(played.tone.amplitude, amplitude)) <= 0.05);
        CHECK(std::abs(1200.0 * std::log2(played.tone.frequency / frequency)) < 0.1);
      }
    }
  }
}

TEST_CASE("two strings that one stroke plucks are each as loud as alone") {
  Instrument both(2, plucked_string(0.0), wave_options());
  for (double z = -12e-3; z < 60e-3; z += 0.8e-3) both.tick(Vector3(0.2, 3e-3, z));
  for (int i = 0; i < 20; ++i) both.tick(both.p_WH);
  for (int string = 0; string < 2; ++string) {
    const GridPluck way{.lambda = 0.2 / 1.1, .speed = 0.8, .height = 3e-3, .finger = {}};
    GridString grid;
    grid.frequency = kTuning[string];
    grid.loss = 0.001;
    grid.loss_n2 = 0.002;
    const GridTone truth = pluck(grid, way, 1100);
    REQUIRE(both.reading(string) != nullptr);
    CHECK(std::abs(decibels(both.reading(string)->energy, truth.energy)) <= 1.0);
  }
}

}  // namespace
}  // namespace hapticd::test
