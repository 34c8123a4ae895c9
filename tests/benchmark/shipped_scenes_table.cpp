// Whole ticks of the shipped scenes and of a hand of 36 spheres (shipped_play.h), pose sample to
// limited wrench with all strings' responses: prints a markdown table of the time of the thread per
// tick and of the work. Every motion is played several times; a tick's time is the median of its
// repetitions, less what the clock itself costs, and the columns are over the ticks that press
// something (all, where none does). --quick plays each twice.
// usage: shipped_scenes_table [--quick] [PLAY]
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <exception>

#include "tests/benchmark/shipped_play.h"
#include "tests/benchmark/tick_times.h"

namespace hapticd::test {
namespace {

/// What reading the clock twice costs, us.
double clock_cost() {
  std::vector<double> times;
  for (int k = 0; k < 1000; ++k) {
    const double before = thread_microseconds();
    times.push_back(thread_microseconds() - before);
  }
  return quantile(times, 0.5);
}

/// Per tick of one play.
struct Ticks {
  std::vector<double> us, tests, sub_steps, contacts, active;
};

/// Of the ticks that press something, or of all where none does.
Ticks measure(const ShippedPlayName& name, int repetitions) {
  ShippedPlay play(name);
  const double clock = clock_cost();
  std::vector<std::vector<double>> times(play.ticks());
  std::vector<PlayWork> work(play.ticks());
  for (int repetition = 0; repetition < repetitions; ++repetition) {
    play.restart();
    for (std::size_t k = 0; k < play.ticks(); ++k) {
      const double before = thread_microseconds();
      play.step();
      times[k].push_back(thread_microseconds() - before - clock);
      work[k] = play.work();
    }
  }
  const bool any =
      std::any_of(work.begin(), work.end(), [](const PlayWork& w) { return w.active > 0; });
  Ticks ticks;
  for (std::size_t k = 0; k < play.ticks(); ++k) {
    if (any && work[k].active == 0) continue;
    ticks.us.push_back(quantile(times[k], 0.5));
    ticks.tests.push_back(static_cast<double>(work[k].tests));
    ticks.sub_steps.push_back(work[k].sub_steps);
    ticks.contacts.push_back(work[k].contacts);
    ticks.active.push_back(work[k].active);
  }
  return ticks;
}

void print(const ShippedPlayName& name, const Ticks& t) {
  std::printf("| %s | %zu | %.2f | %.1f | %.1f |", name.what, t.us.size(), quantile(t.us, 0.5),
              quantile(t.us, 0.99), quantile(t.us, 1.0));
  if (name.target_us > 0.0) {
    std::printf(" %g %s |", name.target_us,
                quantile(t.us, 0.5) <= name.target_us ? "met" : "**not met**");
  } else {
    std::printf(" |");
  }
  std::printf(" %.0f | %.0f | %.0f | %.0f | %.0f | %.0f | %.0f |\n", quantile(t.tests, 0.5),
              quantile(t.tests, 0.99), quantile(t.sub_steps, 0.5), quantile(t.sub_steps, 1.0),
              quantile(t.contacts, 0.5), quantile(t.contacts, 1.0), quantile(t.active, 1.0));
  std::fflush(stdout);
}

void run(int repetitions, const char* only) {
  std::printf(
      "| play | ticks | p50 us | p99 us | max us | asked p50 us | tests p50 | tests p99 | "
      "sub-steps p50 | "
      "most | contacts p50 | most | most active |\n|---|%s\n",
      "---:|---:|---:|---:|---|---:|---:|---:|---:|---:|---:|---:|");
  for (const ShippedPlayName& name : shipped_plays()) {
    if (only == nullptr || std::strcmp(only, name.name) == 0) {
      print(name, measure(name, repetitions));
    }
  }
}

}  // namespace
}  // namespace hapticd::test

int main(int argc, char** argv) {
  const bool quick = argc > 1 && std::strcmp(argv[1], "--quick") == 0;
  const int first = quick ? 2 : 1;
  try {
    hapticd::test::run(quick ? 2 : 7, argc > first ? argv[first] : nullptr);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "shipped_scenes_table: %s\n", error.what());
    return 1;
  }
}
