// A finger that sweeps over seven strings: each is let go once, in order, where the geometry of the
// hand's way says, whatever the work the contact problem is given.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/core/simulation/simulation_fixture.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr int kStrings = 7;
/// Height of the finger's centre below the strings' axes, m.
constexpr double kDepth = 3e-3;
/// Allowed error of the instant of a release, s.
constexpr double kInstantError = 5e-6;

/// z of a string, m.
double place(int string) { return 0.02 * string; }

/// A sweep over all strings.
struct Sweep {
  double speed;  ///< m/s
  double way;    ///< 1: from the first string to the last; -1: back
  int sub_steps;
};

/// Plays the sweep and checks its events. Returns the largest error of the instant of a release, s.
double check_sweep(const Preset& preset, const Sweep& sweep) {
  const std::string played = std::string(preset.name) + " at " +
                             std::to_string(sweep.way * sweep.speed) + " m/s, sub-steps " +
                             std::to_string(sweep.sub_steps);
  CAPTURE(played);
  Instrument guqin(kStrings, preset.string, preset.options);
  guqin.scene().options.sub_steps = sweep.sub_steps;
  const double from = sweep.way > 0.0 ? -0.01 : place(kStrings - 1) + 0.01;
  const double to = place(kStrings - 1) - from;
  guqin.tick({0.2, -kDepth, from});
  guqin.glide({0.2, -kDepth, to}, sweep.speed, [](const SimulationTick&) {});
  CHECK(count(guqin.events, StringEventKind::kTouch) == kStrings);
  CHECK(count(guqin.events, StringEventKind::kTone) == kStrings);
  CHECK(count(guqin.events, StringEventKind::kLeave) == 0);
  const auto releases = of_kind(guqin.events, StringEventKind::kRelease);
  REQUIRE(releases.size() == kStrings);

  const double d = felt_distance(guqin);
  const double reach = std::sqrt(d * d - kDepth * kDepth);
  // The first tick, at 1 ms, stands at `from`.
  const double ticks = std::round(std::abs(to - from) / (sweep.speed * 1e-3));
  const double true_speed = std::abs(to - from) / (ticks * 1e-3);
  double worst = 0.0;
  for (int k = 0; k < kStrings; ++k) {
    const auto& release = releases[static_cast<std::size_t>(k)];
    const int string = sweep.way > 0.0 ? k : kStrings - 1 - k;
    CHECK(release.string == string);
    const double left = 1e-3 + ((place(string) - from) * sweep.way + reach) / true_speed;
    worst = std::max(worst, std::abs(1e-9 * static_cast<double>(release.t_ns) - left));
    if (k > 0) CHECK(release.t_ns > releases[static_cast<std::size_t>(k - 1)].t_ns);
  }
  return worst;
}

}  // namespace

TEST_CASE("a sweep over seven strings lets go of each once, in order, for every sub-step count") {
  // A thin scale plays every so many counts.
  const int stride = static_cast<int>(std::max<std::int64_t>(1, 64 / scaled(640)));
  double worst = 0.0;
  for (const Preset& preset : {paper_preset(), deflecting_preset()}) {
    for (const double speed : {0.1, 0.5, 2.0}) {
      for (int sub_steps = 1; sub_steps <= 64; sub_steps += stride) {
        worst = std::max(worst, check_sweep(preset, {speed, 1.0, sub_steps}));
        worst = std::max(worst, check_sweep(preset, {speed, -1.0, sub_steps}));
      }
    }
  }
  MESSAGE("largest error of the instant of a release: " << worst * 1e6 << " us");
  CHECK(worst < kInstantError);
}

}  // namespace hapticd::test
