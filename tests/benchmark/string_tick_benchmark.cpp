// What strings cost: whole ticks of a finger of one sphere among strings that sleep, are touched,
// or ring. An iteration is a period of 1000 ticks, an item a tick; `sub_steps` per tick, `force_N`
// the greatest. Names: what the finger does / the strings.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <string>

#include "core/math/elementary.h"
#include "tests/core/simulation/simulation_fixture.h"

namespace hapticd::test {
namespace {

constexpr int kPeriodTicks = 1000;
constexpr double kLambda = 0.3;
/// Height at which the finger just touches a string, m.
constexpr double kTouch = 5e-3 + 0.34e-3;

struct Play {
  const char* motion;
  double depth;      ///< of the finger into the string, m; negative: above it
  double amplitude;  ///< of its motion, m
  bool pluck;        ///< the string rings first
};

struct Strings {
  const char* name;
  int count;
  StringContact model;
  bool friction;
  int modes;
};

constexpr Play kPlays[] = {{"far", -50e-3, 1e-3, false},   {"near", -2e-3, 1e-3, false},
                           {"held", 2e-3, 0.0, false},     {"moving", 2e-3, 0.5e-3, false},
                           {"ringing", -50e-3, 0.0, true}, {"ringing_touched", 0.5e-3, 0.0, true}};

constexpr Strings kStrings[] = {{"rigid_1", 1, StringContact::kStraight, false, 0},
                                {"yielding_1", 1, StringContact::kYielding, false, 0},
                                {"yielding_7", 7, StringContact::kYielding, false, 0},
                                {"yielding_107", 107, StringContact::kYielding, false, 0},
                                {"friction_1", 1, StringContact::kYielding, true, 0},
                                {"modes16_1", 1, StringContact::kYielding, false, 16},
                                {"modes32_1", 1, StringContact::kYielding, false, 32}};

Instrument make_instrument(const Strings& strings) {
  StringParameters prototype;
  prototype.model = strings.model;
  prototype.friction_coefficient = 0.3;
  // So that it neither sleeps nor decays within a measurement.
  prototype.decay = 1000.0;
  prototype.touch_decay = 1000.0;
  InstrumentOptions options;
  options.friction = strings.friction;
  options.modes = strings.modes;
  return {strings.count, prototype, options};
}

void run(benchmark::State& state, const Play& play, const Strings& strings) {
  Instrument instrument = make_instrument(strings);
  const double x = kLambda * 1.1;
  const auto ignore = [](const SimulationTick&) {};
  instrument.tick({x, kTouch + 5e-3, 0.0});
  if (play.pluck) {
    instrument.glide({x, kTouch - 3e-3, 0.0}, 0.2, ignore);
    instrument.glide({x, kTouch + 5e-3, 0.0}, 5.0, ignore);
  }
  instrument.glide({x, kTouch - play.depth, 0.0}, 0.2, ignore);
  double sub_steps = 0.0;
  double force = 0.0;
  for (auto _ : state) {
    for (int k = 0; k < kPeriodTicks; ++k) {
      const double y = play.amplitude * sin_cos(2.0 * kPi * k / 250.0).sin;
      const SimulationTick& output = instrument.tick({x, kTouch - play.depth + y, 0.0});
      sub_steps += output.tool(0).contact.sub_steps;
      force = std::max(force, output.tool(0).F_H_W.f.norm());
    }
    instrument.events.clear();
  }
  const auto ticks = static_cast<double>(state.iterations() * kPeriodTicks);
  state.SetItemsProcessed(state.iterations() * kPeriodTicks);
  state.counters["sub_steps"] = sub_steps / ticks;
  state.counters["force_N"] = force;
}

const bool kRegistered = [] {
  for (const Play& play : kPlays) {
    for (const Strings& strings : kStrings) {
      const std::string name = std::string("strings/") + play.motion + '/' + strings.name;
      benchmark::RegisterBenchmark(name.c_str(), [&play, &strings](benchmark::State& state) {
        run(state, play, strings);
      })->Unit(benchmark::kMillisecond);
    }
  }
  return true;
}();

}  // namespace
}  // namespace hapticd::test
