// What explain says that strings cost: the counted rows where they were counted, and a string on
// the rung that its scene and its tuning let it climb to. Truth: the rows themselves, and the
// ladder of core/README.md.
#include "server/model/string_cost.h"
#include "tests/support/within.h"

#include <doctest/doctest.h>

#include <array>

namespace hapticd::test {
namespace {

struct Row {
  StringDetail level;
  bool stretches;
  int modes;
  int substeps;
  double silent;
  double ringing;
  double pressed;
};

constexpr std::array<Row, 9> kRows{{
#include "server/model/string_costs.inc"
}};

StringParameters tuned(double frequency) {
  StringParameters string;
  string.p_WB = {1.1, 0.0, 0.0};
  string.frequency = frequency;
  return string;
}

InstrumentOptions in_modes(int modes, int substeps = 32) {
  InstrumentOptions options;
  options.modes = modes;
  options.substeps = substeps;
  return options;
}

StringRung wave(int modes, int substeps) { return {StringDetail::kModes, true, modes, substeps}; }

}  // namespace

TEST_CASE("a string costs what was counted where it was counted, and nothing is left out") {
  for (const Row& row : kRows) {
    CAPTURE(row.modes);
    const StringCost cost = string_cost({row.level, row.stretches, row.modes, row.substeps});
    CHECK(cost.silent == within(row.silent, 1e-9));
    if (row.ringing >= 0.0) CHECK(cost.ringing == within(row.ringing, 1e-9));
    CHECK((cost.ringing < 0.0) == (row.ringing < 0.0));
    CHECK(cost.pressed == within(row.pressed, 1e-9));
    CHECK(row.pressed > 0.0);
  }
}

TEST_CASE("a wave that rings costs more with more modes, whatever its sub-steps") {
  const double usual = string_cost(wave(32, 32)).ringing;
  CHECK(string_cost(wave(32, 8)).ringing == usual);
  CHECK(string_cost(wave(64, 64)).ringing == string_cost(wave(64, 8)).ringing);
  CHECK(string_cost(wave(64, 64)).ringing > usual);
  CHECK(string_cost(wave(16, 32)).ringing < usual);
  CHECK(string_cost(wave(4, 8)).ringing > 0.0);
}

TEST_CASE("fewer modes and fewer sub-steps make a pressed wave cheaper, more make it dearer") {
  const double usual = string_cost(wave(32, 32)).pressed;
  CHECK(string_cost(wave(16, 32)).pressed < usual);
  CHECK(string_cost(wave(32, 16)).pressed < usual);
  CHECK(string_cost(wave(8, 8)).pressed < string_cost(wave(8, 16)).pressed);
  CHECK(string_cost(wave(64, 64)).pressed > 2.0 * usual);
  CHECK(string_cost(wave(4, 8)).pressed > 0.0);
}

TEST_CASE("a string is on the rung that its scene, its tuning and its model let it climb to") {
  StringParameters string = tuned(65.4);
  CHECK(rung_of(string, in_modes(32)) == wave(32, 32));
  CHECK(rung_of(string, in_modes(16, 64)) == wave(16, 64));
  // Four modes, each a quarter of a turn in a sub-step, have to fit.
  CHECK(rung_of(tuned(130.0), in_modes(32, 8)) == wave(12, 8));
  CHECK(rung_of(tuned(600.0), in_modes(32, 8)).level == StringDetail::kFundamental);
  CHECK(rung_of(string, in_modes(0)).level == StringDetail::kFundamental);
  CHECK(rung_of(tuned(0.0), in_modes(32)).level == StringDetail::kStatic);
  InstrumentOptions still = in_modes(0);
  still.vibration = false;
  CHECK(rung_of(string, still).level == StringDetail::kStatic);
  string.axial_stiffness = 0.0;
  CHECK(!rung_of(string, in_modes(32)).stretches);
  string.model = StringContact::kStraight;
  CHECK(rung_of(string, in_modes(32)).level == StringDetail::kFundamental);
  string.max_level = StringDetail::kLine;
  CHECK(rung_of(string, in_modes(32)).level == StringDetail::kLine);
}

}  // namespace hapticd::test
