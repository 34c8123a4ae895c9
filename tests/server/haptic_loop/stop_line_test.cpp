// A Stop and a dead-man by the Stop road's words, in ticks: with rings that nobody empties, against
// Clears that wait, from another thread, and as a replay sees it. Truth: the finger in the wall
// feels stiffness times depth, or nothing.
#include "server/haptic_loop/stop_line.h"

#include <doctest/doctest.h>

#include <atomic>
#include <thread>

#include "server/haptic_loop/haptic_loop.h"
#include "tests/server/haptic_loop/loop_run.h"

namespace hapticd::test {
namespace {

const Vector3 kHome{0.0, 0.0, 0.025};
const Vector3 kPressed{0.0, 0.0, 0.001};
/// At 1000 N/m, 4 mm deep.
constexpr double kFelt = 3.9;
constexpr std::int64_t kMs = 1'000'000;

/// One that presses into the wall with full force.
struct Pressing {
  explicit Pressing(bool real_time = false) : run(kWallScene, setting(real_time)) {
    run.engage(kHome);
    for (int k = 0; k < 100; ++k) run.tick(kPressed);
    REQUIRE(force(run.tick(kPressed)).norm() > kFelt);
  }
  static LoopSetting setting(bool real_time) {
    LoopSetting made;
    made.real_time = real_time;
    return made;
  }
  /// Until force is back, or for a second.
  bool comes_back() {
    for (int k = 0; k < 300; ++k) run.tick(kHome);
    for (int k = 0; k < 200; ++k) run.tick(kPressed);
    return force(run.tick(kPressed)).norm() > kFelt;
  }

  LoopRun run;
};

TEST_CASE("a Stop by the road makes the force zero in the tick that begins next, and stays") {
  for (const bool real_time : {false, true}) {
    Pressing pressing(real_time);
    LoopRun& run = pressing.run;
    StopLine& line = run.channels().stop;
    line.ask();
    CHECK(line.waits());
    const ToldTick& told = run.tick(kPressed);
    CHECK(force(told).norm() == 0.0);
    CHECK(told.tick.cause == Cause::kStopped);
    CHECK((told.tick.orders & kOrderStop) != 0);
    CHECK(count<FaultNotice>(told) == 1);
    CHECK_FALSE(line.waits());
    CHECK(line.told().state == LoopState::kFault);
    CHECK(line.told().tick == static_cast<std::uint32_t>(told.tick.tick));
    for (int k = 0; k < 500; ++k) {
      REQUIRE(force(run.tick(kPressed)).norm() == 0.0);
      REQUIRE((run.tick(kPressed).tick.orders & kOrderStop) == 0);
    }
    run.send(ClearCommand{});
    CHECK(pressing.comes_back());
  }
}

TEST_CASE("a ring full of commands does not delay it") {
  Pressing pressing;
  LoopRun& run = pressing.run;
  while (run.channels().commands.push(LoopCommand{1, RecentreCommand{0}})) {
  }
  run.channels().stop.ask();
  CHECK(force(run.tick(kPressed)).norm() == 0.0);
}

TEST_CASE("a Clear that is obeyed in the same tick does not end it, one in the next does") {
  Pressing pressing;
  LoopRun& run = pressing.run;
  run.send(ClearCommand{});
  run.channels().stop.ask();
  CHECK(run.tick(kPressed).tick.state == LoopState::kFault);
  for (int k = 0; k < 300; ++k) REQUIRE(run.tick(kPressed).tick.state == LoopState::kFault);
  run.channels().stop.ask();
  REQUIRE(run.tick(kPressed).tick.state == LoopState::kFault);
  run.send(ClearCommand{});
  CHECK(pressing.comes_back());
}

TEST_CASE("a heartbeat that stays away fades the force in 50 ms, and brings it back in 200 ms") {
  Pressing pressing(true);
  LoopRun& run = pressing.run;
  StopLine& line = run.channels().stop;
  line.hold_until(run.now_ns() + 20 * kMs);
  for (int k = 0; k < 20; ++k) REQUIRE(force(run.tick(kPressed)).norm() > kFelt);
  double before = force(run.tick(kPressed)).norm();
  for (int k = 0; k < 49; ++k) {
    const ToldTick& told = run.tick(kPressed);
    CHECK((told.tick.orders & kOrderDeadMan) != 0);
    CHECK(told.tick.cause == Cause::kDeadMan);
    CHECK(force(told).norm() <= before);
    before = force(told).norm();
  }
  CHECK(force(run.tick(kPressed)).norm() == 0.0);
  CHECK(run.tick(kPressed).tick.state == LoopState::kReady);
  for (int k = 0; k < 1000; ++k) REQUIRE(force(run.tick(kHome)).norm() == 0.0);
  line.hold_until(run.now_ns() + 10'000 * kMs);
  REQUIRE(run.tick(kHome).tick.state == LoopState::kEngaged);
  for (int k = 0; k < 205; ++k) run.tick(kHome);
  for (int k = 0; k < 100; ++k) run.tick(kPressed);
  CHECK(force(run.tick(kPressed)).norm() > kFelt);
  CHECK((run.tick(kPressed).tick.orders & kOrderDeadMan) == 0);
}

TEST_CASE("Clears are told, so that absent dead-men can be let go") {
  Pressing pressing;
  const std::uint32_t before = pressing.run.channels().stop.told().clears;
  pressing.run.send(ClearCommand{});
  pressing.run.tick(kHome);
  CHECK(pressing.run.channels().stop.told().clears == before + 1);
}

TEST_CASE("of Stops from another thread none is lost, and no tick has force that began after one") {
  Pressing pressing;
  LoopRun& run = pressing.run;
  StopLine& line = run.channels().stop;
  std::atomic<int> asked{0};
  std::atomic<bool> over{false};
  std::thread road([&] {
    while (!over.load()) {
      if (line.told().state == LoopState::kFault || line.waits()) continue;
      line.ask();
      asked.fetch_add(1);
    }
  });
  int latched = 0;
  // However seldom the system lets the other thread run.
  for (int k = 0; k < 20'000 || (asked.load() <= 10 && k < 2'000'000); ++k) {
    const int before = asked.load();
    const ToldTick& told = run.tick(kHome);
    if ((told.tick.orders & kOrderStop) != 0) ++latched;
    if (before > latched) FAIL("a Stop that was asked for before the tick is not in it");
    if (told.tick.state == LoopState::kFault) run.send(ClearCommand{});
  }
  over.store(true);
  road.join();
  run.tick(kHome);
  CHECK(asked.load() > 10);
  CHECK(asked.load() - latched <= 1);
}

}  // namespace
}  // namespace hapticd::test
