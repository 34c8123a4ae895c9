// The force of a ringing string under a finger, by the levels of the ladder, against the offline
// truth. Bounds leave twice the error measured (tests/benchmark/string_table).
#include <doctest/doctest.h>

#include <vector>

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
double worst(const std::vector<PressCase>& cases, int modes, int steps) {
  double greatest = 0.0;
  for (const PressCase& press_case : cases) {
    const double error = press_error(play_modal(press_case, modes, steps), press_case).rms_percent;
    if (!(error <= greatest)) greatest = error;
  }
  return greatest;
}

TEST_CASE("each doubling of the modes brings a touched string closer to the truth") {
  const std::vector<PressCase> soft = cases(1e3);
  CHECK(worst(soft, 4, 64) <= 40.0);
  CHECK(worst(soft, 8, 64) <= 13.0);
  CHECK(worst(soft, 16, 64) <= 0.9);
  CHECK(worst(soft, 32, 64) <= 0.4);
  CHECK(worst(soft, 64, 64) <= 0.4);
}

TEST_CASE("more contact steps bring a touched string closer to the truth") {
  const std::vector<PressCase> soft = cases(1e3);
  CHECK(worst(soft, 32, 4) <= 9.0);
  CHECK(worst(soft, 32, 16) <= 1.5);
  CHECK(worst(soft, 32, 64) <= 0.4);
  CHECK(worst(soft, 32, 256) <= 0.4);
}

TEST_CASE("a finger of 10 kN/m is felt within 4 % with 32 modes, within 1 % with 64") {
  const std::vector<PressCase> stiff = cases(1e4);
  CHECK(worst(stiff, 32, 64) <= 4.0);
  CHECK(worst(stiff, 64, 64) <= 1.0);
}

TEST_CASE("the printed Eq. 9 misses the force of a touched string by more than all of it") {
  for (const PressCase& press_case : cases(1e3)) {
    CHECK(press_error(play_printed(press_case, true), press_case).rms_percent >= 100.0);
    CHECK(press_error(play_printed(press_case, false), press_case).rms_percent <= 60.0);
  }
}

}  // namespace
}  // namespace hapticd::test
