// Strings that sound, played by a tool through the whole tick, against finite differences of the
// string and of what holds the tool.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "tests/core/simulation/simulation_fixture.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/truth/played_string.h"

namespace hapticd::test {
namespace {

InstrumentOptions wave_options() {
  InstrumentOptions options;
  options.modes = 32;
  return options;
}

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
  double bent = 0.0;
};

Pluck pluck_with(const GridPluck& way, const StringParameters& string) {
  Instrument instrument(1, string, wave_options());
  const double x = 1.1 * way.lambda;
  instrument.tick(Vector3(x, way.height, -12e-3));
  Pluck left;
  const auto look = [&](const SimulationTick&) {
    if (const StringTick* row = instrument.reading(0)) {
      left.bent = std::max(left.bent, to_vector(row->deflection_W).norm());
    }
  };
  instrument.glide(Vector3(x, way.height, 60e-3), way.speed, look);
  for (int i = 0; i < 20; ++i) instrument.tick(instrument.p_WH);
  for (const StringEvent& event : instrument.events) {
    if (event.kind != StringEventKind::kTone) continue;
    ++left.tones;
    left.tone = event;
  }
  const StringTick* row = instrument.reading(0);
  left.energy = row == nullptr ? 0.0 : row->energy;
  return left;
}

TEST_CASE("plucks through the tick are as loud as finite differences find them") {
  for (const double frequency : {65.4, 146.8}) {
    for (const double lambda : {0.1, 0.25, 0.5}) {
      for (const double speed : {0.45, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.5}) {
        const GridPluck way{.lambda = lambda, .speed = speed, .height = 3e-3, .finger = {}};
        GridString grid;
        grid.frequency = frequency;
        grid.loss = 0.001;
        grid.loss_n2 = 0.002;
        const GridTone truth = pluck(grid, way, 1100);
        const Pluck played = pluck_with(way, plucked_string(frequency));
        const double A1 = played.tone.amplitude * static_cast<double>(played.tone.partials[0]);
        MESSAGE(frequency << " " << lambda << " " << speed << " tones " << played.tones << " E "
                          << played.energy << " / " << truth.energy << " = "
                          << 10.0 * std::log10(played.energy / truth.energy) << " dB, amplitude "
                          << played.tone.amplitude << ", A1 truth " << truth.amplitude << " " << A1
                          << " bent " << played.bent << " " << truth.deflection);
      }
    }
  }
}

}  // namespace
}  // namespace hapticd::test
