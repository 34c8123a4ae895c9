// The whole contact tick: one tool, pose sample in, limited wrench out, on the scenes and motions
// of tick_scene.h. An iteration is a period of 1000 ticks, an item a tick. Counters, per tick:
// p50_ns and p99.9_ns of single ticks (the clock costs about 25 ns); cold_ns, the median with the
// first two cache levels emptied before each tick, as after a sleep; sub_steps and most_sub_steps;
// tests = bounds and pairs evaluated; contacts within the margin; force_N = the greatest.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <string>

#include "tests/benchmark/tick_scene.h"

namespace hapticd::test {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kColdTicks = 200;
/// Twice the second-level cache of common machines, bytes.
constexpr std::size_t kCacheBytes = 4U << 20U;
constexpr std::size_t kCacheLine = 64;

double percentile(std::vector<double>& values, double share) {
  const auto k = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

double timed_tick(TickScene& scene) {
  const auto start = Clock::now();
  benchmark::DoNotOptimize(scene.tick());
  return std::chrono::duration<double, std::nano>(Clock::now() - start).count();
}

double cold_median(TickScene& scene) {
  std::vector<char> filler(kCacheBytes);
  std::vector<double> nanoseconds;
  for (int k = 0; k < kColdTicks; ++k) {
    for (std::size_t i = 0; i < filler.size(); i += kCacheLine) ++filler[i];
    benchmark::ClobberMemory();
    nanoseconds.push_back(timed_tick(scene));
    // Sample the whole period.
    for (int skipped = 1; skipped < kPeriodTicks / kColdTicks; ++skipped) scene.tick();
  }
  return percentile(nanoseconds, 0.5);
}

/// What the ticks of one period do; the same in every period and run.
void count_work(benchmark::State& state, TickScene& scene) {
  double sub_steps = 0.0;
  double tests = 0.0;
  double contacts = 0.0;
  double force = 0.0;
  int most_sub_steps = 0;
  for (int k = 0; k < kPeriodTicks; ++k) {
    const RenderedTool& tick = scene.tick();
    sub_steps += tick.contact.sub_steps;
    most_sub_steps = std::max(most_sub_steps, tick.contact.sub_steps);
    tests += static_cast<double>(tick.contact.tests);
    contacts += scene.contacts();
    force = std::max(force, tick.F_H_W.f.norm());
  }
  state.counters["sub_steps"] = sub_steps / kPeriodTicks;
  state.counters["most_sub_steps"] = most_sub_steps;
  state.counters["tests"] = tests / kPeriodTicks;
  state.counters["contacts"] = contacts / kPeriodTicks;
  state.counters["force_N"] = force;
}

void run(benchmark::State& state, const TickParts& parts, Motion motion) {
  TickScene scene(parts, motion);
  std::vector<double> nanoseconds;
  for (auto _ : state) {
    for (int k = 0; k < kPeriodTicks; ++k) nanoseconds.push_back(timed_tick(scene));
  }
  state.SetItemsProcessed(state.iterations() * kPeriodTicks);
  state.counters["p50_ns"] = percentile(nanoseconds, 0.5);
  state.counters["p99.9_ns"] = percentile(nanoseconds, 0.999);
  state.counters["cold_ns"] = cold_median(scene);
  count_work(state, scene);
}

const bool kRegistered = [] {
  for (const NamedParts& scene : timed_scenes()) {
    for (const NamedMotion& motion : timed_motions()) {
      const std::string name = std::string("tick/") + scene.name + '/' + motion.name;
      benchmark::RegisterBenchmark(name.c_str(), [scene, motion](benchmark::State& state) {
        run(state, scene.parts(), motion.motion);
      })->Unit(benchmark::kMillisecond);
    }
  }
  return true;
}();

}  // namespace
}  // namespace hapticd::test
