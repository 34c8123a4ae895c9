// The force of a ringing string under a finger, by the rungs of the ladder, against the offline
// truth. Bounds leave up to twice the error measured (tests/benchmark/string_table).
#include <doctest/doctest.h>

#include <vector>

#include "core/instrument/string_motion.h"
#include "tests/truth/press_run.h"

namespace hapticd::test {
namespace {

constexpr int kTruthRate = 400'000;

std::vector<PressCase> cases(double stiffness) {
  std::vector<PressCase> made;
  for (const double frequency : {65.4, 146.8}) {
    for (const double pluck_lambda : {0.1, 0.5}) {
      made.push_back(make_press_case(frequency, pluck_lambda, stiffness, kTruthRate));
    }
  }
  return made;
}

/// Greatest rms error over the cases, in percent of the rms force.
double worst(const std::vector<PressCase>& cases, int modes) {
  double greatest = 0.0;
  for (const PressCase& press_case : cases) {
    const double error = press_error(play_wave(press_case, modes), press_case).rms_percent;
    if (!(error <= greatest)) greatest = error;
  }
  return greatest;
}

TEST_CASE("each doubling of the modes brings a touched string closer to the truth") {
  const std::vector<PressCase> soft = cases(1e3);
  CHECK(worst(soft, 4) <= 80.0);
  CHECK(worst(soft, 8) <= 40.0);
  CHECK(worst(soft, 16) <= 9.0);
  CHECK(worst(soft, 32) <= 2.0);
  CHECK(worst(soft, 64) <= 2.0);
}

TEST_CASE("a finger of 10 kN/m is felt as exactly as so many modes and steps allow") {
  // What the waves that run between finger and ends do next depends on all modes: the truth itself
  // errs as much where it has fewer of them, and the sub-steps of the wave.
  for (const PressCase& press_case : cases(1e4)) {
    for (const int modes : {32, 64}) {
      PressRun coarse;
      coarse.force =
          play_modes(press_case.truth_string, press_case.press, modes, 1000 * kSubSteps).force;
      const double allowed = press_error(coarse, press_case).rms_percent;
      CHECK(press_error(play_wave(press_case, modes), press_case).rms_percent <= allowed);
    }
  }
}

TEST_CASE("plucked by a hand, a string with modes presses a finger as one that was let go") {
  InstrumentOptions options;
  options.modes = 32;
  for (const PressCase& press_case : cases(1e3)) {
    const double error = press_error(play_ladder(press_case, options), press_case).rms_percent;
    CHECK(error <= 3.5);
  }
}

TEST_CASE("the printed Eq. 9 misses the force of a touched string by more than all of it") {
  for (const PressCase& press_case : cases(1e3)) {
    CHECK(press_error(play_printed(press_case, true), press_case).rms_percent >= 100.0);
    CHECK(press_error(play_printed(press_case, false), press_case).rms_percent <= 80.0);
  }
}

}  // namespace
}  // namespace hapticd::test
