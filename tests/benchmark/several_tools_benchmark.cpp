// What several tools cost: whole ticks of one to five fingers, each at a string of its own or all
// at one. An iteration is a period of 500 ticks, an item a tick; `times_one` is the time over that
// of one tool of the same table, measured in the same run. Names: what the fingers do / how many.
#include <benchmark/benchmark.h>

#include <ctime>
#include <map>
#include <string>

#include "core/math/elementary.h"
#include "tests/core/simulation/ensemble.h"

namespace hapticd::test {
namespace {

constexpr int kPeriodTicks = 500;
/// Height at which a fingertip just touches a string, m.
constexpr double kTouch = kEnsembleTip + 0.34e-3;

struct Play {
  const char* name;
  double depth;  ///< of the fingers into the strings, m; negative: above them
  double swing;  ///< of their motion, m
  bool share;    ///< all at one string
};

constexpr Play kPlays[] = {{"far", -0.1, 1e-3, false},
                           {"held_apart", 2e-3, 0.0, false},
                           {"moving_apart", 2e-3, 0.5e-3, false},
                           {"held_shared", 2e-3, 0.0, true},
                           {"moving_shared", 2e-3, 0.5e-3, true}};

std::vector<Vector3> fingers(const Play& play, std::size_t count, int tick) {
  std::vector<Vector3> p;
  for (std::size_t k = 0; k < count; ++k) {
    const double y =
        play.swing * sin_cos(2.0 * kPi * (tick + 40 * static_cast<int>(k)) / 250.0).sin;
    const double place = static_cast<double>(k);
    const Vector3 at =
        play.share ? Vector3(0.2 + 0.15 * place, 0.0, 0.0) : Vector3(0.35, 0.0, 0.02 * place);
    p.emplace_back(at.x(), kTouch - play.depth + y, at.z());
  }
  return p;
}

/// Seconds of processor time per tick of one tool, by name of the play.
std::map<std::string, double>& one_tool() {
  static std::map<std::string, double> seconds;
  return seconds;
}

void run(benchmark::State& state, const Play& play, std::size_t count) {
  Ensemble ensemble(count, {});
  for (int tick = 0; tick < 100; ++tick) {
    std::vector<Vector3> p = fingers(play, count, 0);
    for (Vector3& place : p) place.y() += 10e-3 * (1.0 - tick / 100.0);
    ensemble.tick(p);
  }
  std::vector<std::vector<HandPose>> inputs;
  inputs.reserve(kPeriodTicks);
  for (int tick = 0; tick < kPeriodTicks; ++tick) {
    inputs.push_back(ensemble.hands(fingers(play, count, tick)));
  }
  SimulationTick output;
  double sub_steps = 0.0;
  const std::clock_t start = std::clock();
  std::int64_t t_ns = 200'000'000;
  for (auto _ : state) {
    for (std::vector<HandPose>& hands : inputs) {
      t_ns += 1'000'000;
      for (HandPose& hand : hands) hand.t_ns = t_ns;
      output.step(ensemble.simulation(), hands);
      for (std::size_t k = 0; k < count; ++k) sub_steps += output.tool(k).contact.sub_steps;
    }
  }
  const auto ticks = static_cast<double>(state.iterations() * kPeriodTicks);
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / ticks;
  if (count == 1) one_tool()[play.name] = seconds;
  state.SetItemsProcessed(state.iterations() * kPeriodTicks);
  state.counters["sub_steps"] = sub_steps / ticks;
  const auto one = one_tool().find(play.name);
  if (one != one_tool().end()) state.counters["times_one"] = seconds / one->second;
}

const bool kRegistered = [] {
  for (const Play& play : kPlays) {
    for (std::size_t count = 1; count <= kMaxTools; ++count) {
      const std::string name = std::string("tools/") + play.name + '/' + std::to_string(count);
      benchmark::RegisterBenchmark(name.c_str(), [&play, count](benchmark::State& state) {
        run(state, play, count);
      })->Unit(benchmark::kMillisecond);
    }
  }
  return true;
}();

}  // namespace
}  // namespace hapticd::test
