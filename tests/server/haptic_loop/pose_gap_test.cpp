// A scripted device on the real clock whose poses come late, pause or have not begun. Truth: the
// times that PROTOCOL.md gives: two ticks are bridged, then the force goes in 50 ms and comes in
// 200 ms.
#include <doctest/doctest.h>

#include "tests/server/haptic_loop/loop_run.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

const LoopSetting kStream{"scripted", "ideal", false, true};
const Vector3 kFree{0.0, 0.0, 0.025};
const Vector3 kPressed{0.0, 0.0, 0.004};

/// Pressed into the wall at full gain; the force there.
double press(LoopRun& run) {
  run.engage(kFree);
  for (int tick = 0; tick < 100; ++tick) {
    run.tick(kFree + (kPressed - kFree) * (tick / 100.0));
  }
  double pressed = 0.0;
  for (int tick = 0; tick < 300; ++tick) pressed = force(run.tick(kPressed)).norm();
  REQUIRE(pressed > 0.5);
  return pressed;
}

}  // namespace

TEST_CASE("before the first pose the loop waits for as long as it takes, and then plays") {
  LoopRun run(kWallScene, kStream);
  for (int tick = 0; tick < 2000; ++tick) {
    const ToldTick& told = run.tick();
    REQUIRE(told.tick.state == LoopState::kDetached);
    REQUIRE(force(told).norm() == 0.0);
  }
  press(run);
}

TEST_CASE("a pause of poses fades the force, and is no fault until there is none left") {
  SplitMix64 random(fresh_seed());
  for (std::int64_t k = 0; k < scaled(60); ++k) {
    LoopRun run(kWallScene, kStream);
    const double pressed = press(run);
    const int gap = static_cast<int>(random.below(51));
    CAPTURE(gap);
    double before = pressed;
    for (int missed = 1; missed <= gap; ++missed) {
      const ToldTick& told = run.tick();
      REQUIRE(told.tick.state == LoopState::kEngaged);
      const double left = std::max(0.0, 1.0 - std::max(0, missed - 2) / 50.0);
      CHECK(force(told).norm() <= left * pressed * (1.0 + 1e-9));
      CHECK(force(told).norm() <= before * (1.0 + 1e-9));
      CHECK(told.tick.cause == (missed > 2 ? Cause::kInputStale : Cause::kNone));
      before = force(told).norm();
    }
    double after = before;
    for (int tick = 0; tick < 210; ++tick) after = force(run.tick(kPressed)).norm();
    CHECK(after == within(pressed, 0.05));
  }
}

TEST_CASE("poses that stay away are a fault once the force has gone") {
  LoopRun run(kWallScene, kStream);
  press(run);
  LoopState state = LoopState::kEngaged;
  int ticks = 0;
  double last = 0.0;
  while (state != LoopState::kFault && ticks < 200) {
    const ToldTick& told = run.tick();
    state = told.tick.state;
    last = force(told).norm();
    ++ticks;
  }
  CHECK(ticks == 53);
  CHECK(last == 0.0);
}

TEST_CASE("a scene loaded in contact waits for poses of its own, and is played without a fault") {
  LoopRun run(kWallScene, kStream);
  press(run);
  run.swap_to(played_scene(kWallScene, 2, kStream));
  // The ramp out takes 50 ticks. Whoever sends poses needs a while to hear of the new scene, in
  // which they are for ticks that it will not have for long.
  for (int tick = 0; tick < 40; ++tick) {
    REQUIRE(run.tick(kPressed).tick.state != LoopState::kFault);
  }
  std::uint32_t scene_id = 1;
  for (int tick = 0; tick < 160; ++tick) {
    const Tick& told = run.tick().tick;
    REQUIRE(told.state != LoopState::kFault);
    scene_id = told.scene_id;
  }
  CHECK(scene_id == 2);
  press(run);
}

}  // namespace hapticd::test
