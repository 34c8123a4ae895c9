// Laps of a clock that the test sets.
#include "core/tick/stage_clock.h"

#include <doctest/doctest.h>

namespace hapticd::test {
namespace {

std::int64_t told_ns = 0;
std::int64_t tell() noexcept { return told_ns; }

void lap_at(std::int64_t t_ns, Stage stage, StageClock& clock) {
  told_ns = t_ns;
  lap(&clock, stage);
}

}  // namespace

TEST_CASE("every nanosecond since the start of a tick belongs to one stage") {
  StageClock clock(tell);
  clock.start(1000);
  lap_at(1010, Stage::kRead, clock);
  lap_at(1030, Stage::kOptimisation, clock);
  lap_at(1070, Stage::kCollision, clock);
  lap_at(1150, Stage::kOptimisation, clock);
  lap_at(1310, Stage::kStrings, clock);
  CHECK(clock.times() == StageTimes{10, 40, 100, 160, 0, 0, 0});
  CHECK(simulation_ns(clock.times()) == 300);
  clock.start(2000);
  CHECK(clock.times() == StageTimes{});
  lap(nullptr, Stage::kRead);
}

}  // namespace hapticd::test
