// When ticks come, in a world whose time is the test's: the clock moves only where somebody waits
// or works. Truth: times worked out by hand, in us.
#include "server/haptic_loop/tick_pace.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "tests/support/random.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kPeriod_ns = 1'000'000;

/// The clock, and the device's reports to come. Of one thread.
struct World {
  std::int64_t now_ns = 0;
  std::int64_t waking_ns = 0;            ///< from what is waited for to the waking
  std::vector<std::int64_t> reports_ns;  ///< rising
  std::size_t seen = 0;                  ///< reports that are there
  bool gone = false;
  std::vector<std::int64_t> used_ns;  ///< of the newest report in each tick, -1: no new one
};
World world;

std::int64_t now() noexcept { return world.now_ns; }
void sleep_until(std::int64_t t_ns) noexcept {
  if (t_ns > world.now_ns) world.now_ns = t_ns + world.waking_ns;
}

std::size_t there() {
  return static_cast<std::size_t>(
      std::upper_bound(world.reports_ns.begin(), world.reports_ns.end(), world.now_ns) -
      world.reports_ns.begin());
}

Waited wait(void* /*device*/, std::int64_t until_ns) noexcept {
  if (world.gone) return Waited::kGone;
  const std::size_t next = there();
  const bool comes = next < world.reports_ns.size() && world.reports_ns[next] <= until_ns;
  sleep_until(comes ? world.reports_ns[next] : until_ns);
  if (comes) return Waited::kReport;
  return next > world.seen ? Waited::kMissed : Waited::kTime;
}

/// Runs so many ticks of `work_ns`; their times.
std::vector<DueTick> run(TickPace& pace, int ticks, std::int64_t work_ns = 100'000) {
  std::vector<DueTick> came;
  came.reserve(static_cast<std::size_t>(ticks));
  for (int k = 0; k < ticks; ++k) {
    came.push_back(pace.wait());
    const std::size_t seen = there();
    world.used_ns.push_back(seen > world.seen ? world.reports_ns[seen - 1] : -1);
    world.seen = seen;
    world.now_ns += work_ns;
  }
  return came;
}

TickPace by_device(std::int64_t frame_ns, std::int64_t period_ns = kPeriod_ns) {
  return {period_ns, {nullptr, wait, frame_ns}, {now, sleep_until}};
}

/// Reports every `frame_ns` from `first_ns` on.
void begin_world(std::int64_t first_ns, std::int64_t frame_ns, int count) {
  world = World{};
  for (int k = 0; k < count; ++k) world.reports_ns.push_back(first_ns + k * frame_ns);
}

}  // namespace

TEST_CASE("by the timer ticks come each period, and one that is late skips those it missed") {
  world = World{};
  TickPace pace(kPeriod_ns, {}, {now, sleep_until});
  auto ticks = run(pace, 3);
  for (std::int64_t k = 0; k < 3; ++k) {
    CHECK(ticks[static_cast<std::size_t>(k)].now_ns == (k + 1) * kPeriod_ns);
  }
  world.now_ns += 3'600'000;  // to 6.7 ms; due was 4 ms
  ticks = run(pace, 2);
  CHECK(ticks[0].now_ns == 6'700'000);
  CHECK(ticks[0].skipped == 2);
  CHECK(ticks[1].now_ns == 7'000'000);
  CHECK(ticks[1].skipped == 0);
}

TEST_CASE("by a device each report begins a tick, though its clock is not the machine's") {
  for (const std::int64_t frame_ns :
       {999'000LL, 1'000'000LL, 1'001'000LL, 1'100'000LL, 800'000LL}) {
    CAPTURE(frame_ns);
    begin_world(1'150'000, frame_ns, 2'000);
    TickPace pace = by_device(frame_ns);
    const auto ticks = run(pace, 2'000);
    for (std::size_t k = 0; k < ticks.size(); ++k) {
      REQUIRE(ticks[k].now_ns == world.reports_ns[k]);
      REQUIRE(ticks[k].skipped == 0);
    }
  }
}

TEST_CASE("the timer's phase is left for the device's within a few ticks, wherever that lies") {
  for (std::int64_t first_ns = 0; first_ns < kPeriod_ns; first_ns += 50'000) {
    CAPTURE(first_ns);
    begin_world(first_ns, kPeriod_ns, 1'000);
    TickPace pace = by_device(kPeriod_ns);
    run(pace, 5);
    const auto ticks = run(pace, 100);
    for (const DueTick& tick : ticks) REQUIRE(tick.now_ns % kPeriod_ns == first_ns);
  }
}

TEST_CASE("of 8000 reports a second every eighth begins a tick, and is the newest") {
  for (const std::int64_t waking_ns : {0, 10'000, 40'000, 50'000}) {
    CAPTURE(waking_ns);
    begin_world(100'000, 125'000, 16'100);
    world.waking_ns = waking_ns;
    TickPace pace = by_device(125'000);
    const auto ticks = run(pace, 2'000);
    for (std::size_t k = 0; k < ticks.size(); ++k) {
      REQUIRE(world.used_ns[k] == ticks[k].now_ns - waking_ns);
      if (k > 0) REQUIRE(ticks[k].now_ns - ticks[k - 1].now_ns == kPeriod_ns);
    }
  }
}

TEST_CASE(
    "a report that does not come is waited for a quarter of a period, and the next has its tick") {
  begin_world(1'000'000, kPeriod_ns, 20);
  world.reports_ns.erase(world.reports_ns.begin() + 5);  // that of 6 ms
  TickPace pace = by_device(kPeriod_ns);
  const auto ticks = run(pace, 10);
  CHECK(ticks[4].now_ns == 5'000'000);
  CHECK(ticks[5].now_ns == 6'250'000);
  CHECK(ticks[5].skipped == 0);
  CHECK(world.used_ns[5] == -1);
  CHECK(ticks[6].now_ns == 7'000'000);
  CHECK(world.used_ns[6] == 7'000'000);
}

TEST_CASE(
    "a device that falls silent or is unplugged leaves ticks each period, and paces them again") {
  for (const bool unplugged : {false, true}) {
    CAPTURE(unplugged);
    begin_world(1'000'000, kPeriod_ns, 10);
    TickPace pace = by_device(kPeriod_ns);
    run(pace, 10);
    world.gone = unplugged;
    const std::int64_t late_ns = unplugged ? 0 : 250'000;
    const auto without = run(pace, 50);
    for (std::int64_t k = 0; k < 50; ++k) {
      REQUIRE(without[static_cast<std::size_t>(k)].now_ns == (11 + k) * kPeriod_ns + late_ns);
      REQUIRE(without[static_cast<std::size_t>(k)].skipped == 0);
    }
    world.gone = false;
    for (int k = 0; k < 10; ++k) world.reports_ns.push_back(61'200'000 + k * kPeriod_ns);
    const auto again = run(pace, 10);
    for (std::size_t k = 0; k < 10; ++k) CHECK(again[k].now_ns == world.reports_ns[10 + k]);
  }
}

TEST_CASE(
    "a slow loop waits no longer for a report than a fast one, far from the guardian's stall") {
  begin_world(4'000'000, 4'000'000, 3);
  TickPace pace = by_device(4'000'000, 4'000'000);
  run(pace, 3);
  CHECK(run(pace, 1)[0].now_ns == 16'250'000);
}

TEST_CASE("a tick that works too long skips what it missed and does not wait for a report") {
  begin_world(1'000'000, kPeriod_ns, 100);
  TickPace pace = by_device(kPeriod_ns);
  run(pace, 3);
  run(pace, 1, 2'600'000);  // from 4 ms to 6.6 ms
  const auto ticks = run(pace, 2);
  CHECK(ticks[0].now_ns == 6'600'000);
  CHECK(ticks[0].skipped == 1);
  CHECK(world.used_ns[4] == 6'000'000);
  CHECK(ticks[1].now_ns == 7'000'000);
  CHECK(ticks[1].skipped == 0);
  run(pace, 1, 1'100'000);  // from 8 ms to 9.1 ms
  CHECK(run(pace, 1)[0].now_ns == 9'100'000);
  CHECK(world.used_ns.back() == 9'000'000);
}

TEST_CASE("however reports come, ticks are half a period to a quarter more than one apart") {
  SplitMix64 random(5);
  for (int run_number = 0; run_number < 20; ++run_number) {
    world = World{};
    const double mean = random.uniform(60'000.0, 3'000'000.0);
    std::int64_t t_ns = 0;
    while (t_ns < 500'000'000) {
      t_ns += 1 + static_cast<std::int64_t>(random.uniform(0.0, 2.0 * mean));
      world.reports_ns.push_back(t_ns);
    }
    TickPace pace = by_device(static_cast<std::int64_t>(mean));
    const auto ticks = run(pace, 300);
    for (std::size_t k = 1; k < ticks.size(); ++k) {
      const std::int64_t apart_ns = ticks[k].now_ns - ticks[k - 1].now_ns;
      REQUIRE(ticks[k].skipped == 0);
      REQUIRE(apart_ns >= kPeriod_ns / 2);
      REQUIRE(apart_ns <= kPeriod_ns + kPeriod_ns / 4);
    }
  }
}

}  // namespace hapticd::test
