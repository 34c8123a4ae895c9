// The loop's law of force at work: ramps, stops, faults, swaps and changes of settings, tick by
// tick under virtual time.
#include "server/haptic_loop/haptic_loop.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/server/haptic_loop/loop_run.h"
#include "tests/support/no_heap.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

/// Of the finger's centre when it touches the wall.
constexpr double kTouch = 0.005;
const Vector3 kHome(0.0, 0.0, 0.025);

Vector3 pressed(double depth) { return {0.0, 0.0, kTouch - depth}; }

}  // namespace

TEST_CASE("a finger pressed into a wall is pushed back by stiffness times depth") {
  LoopRun run(kWallScene);
  run.engage(kHome);
  for (int k = 0; k < 100; ++k) run.tick(pressed(0.005 * k / 99.0));
  const ToldTick& told = run.tick(pressed(0.005));
  // kt = 1000 N/m.
  CHECK(force(told).z() == within(1000.0 * 0.005, 1e-4));
  CHECK(std::abs(force(told).x()) < 1e-9);
}

TEST_CASE("force climbs to all of it in 200 ms after a start, and is zero in the first tick") {
  LoopRun run(kWallScene);
  CHECK(run.tick(kHome).tick.state == LoopState::kReady);
  CHECK(run.tick(kHome).tick.state == LoopState::kEngaged);
  double last = 0.0;
  for (int k = 1; k <= 100; ++k) {
    const ToldTick& told = run.tick(pressed(0.002));
    CHECK(force(told).z() >= last);
    last = force(told).z();
  }
  // Half way up the ramp: half of 2 N, within a tick's worth of ramp.
  CHECK(last == within(1.0, 0.02));
}

TEST_CASE("a tool that starts in contact gets no force, and the reason is told") {
  LoopRun run(kWallScene);
  for (int k = 0; k < 50; ++k) {
    const ToldTick& told = run.tick(pressed(0.003));
    CHECK(force(told).isZero(0.0));
    if (k > 2) CHECK(told.tick.cause == Cause::kOverlap);
  }
}

TEST_CASE("Stop takes all force away in the tick that hears it, until Clear") {
  LoopRun run(kWallScene);
  run.engage(kHome);
  for (int k = 0; k < 20; ++k) run.tick(pressed(0.004));
  REQUIRE(force(run.tick(pressed(0.004))).z() > 3.0);
  run.send(StopCommand{});
  const ToldTick& stopped = run.tick(pressed(0.004));
  CHECK(force(stopped).isZero(0.0));
  CHECK(stopped.tick.state == LoopState::kFault);
  CHECK(count<FaultNotice>(stopped) == 1);
  for (int k = 0; k < 300; ++k) CHECK(force(run.tick(kHome)).isZero(0.0));
  run.send(ClearCommand{});
  run.tick(kHome);
  for (int k = 0; k < 250; ++k) run.tick(kHome);
  CHECK(run.tick(kHome).tick.state == LoopState::kEngaged);
}

TEST_CASE("of Stop and Clear that one tick hears the later counts, and both take all force away") {
  for (const bool stop_last : {false, true}) {
    CAPTURE(stop_last);
    LoopRun run(kWallScene);
    run.engage(kHome);
    for (int k = 0; k < 20; ++k) run.tick(pressed(0.004));
    if (stop_last) run.send(ClearCommand{});
    run.send(StopCommand{});
    if (!stop_last) run.send(ClearCommand{});
    const ToldTick& stopped = run.tick(pressed(0.004));
    CHECK(force(stopped).isZero(0.0));
    CHECK(stopped.tick.state == LoopState::kFault);
    for (int k = 0; k < 300; ++k) run.tick(kHome);
    CHECK(run.tick(kHome).tick.state == (stop_last ? LoopState::kFault : LoopState::kEngaged));
  }
}

TEST_CASE("a pose that is no number takes all force away within two ticks and latches a fault") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  LoopRun run(kWallScene);
  run.engage(kHome);
  for (int k = 0; k < 20; ++k) run.tick(pressed(0.004));
  int with_force = 0;
  for (int k = 0; k < 10; ++k) {
    with_force += force(run.tick(Vector3(0.0, nan, 0.0))).isZero(0.0) ? 0 : 1;
  }
  CHECK(with_force <= 2);
  const ToldTick& told = run.tick(pressed(0.004));
  CHECK(told.tick.state == LoopState::kFault);
  CHECK(told.tick.cause == Cause::kNotFinite);
  CHECK(force(told).isZero(0.0));
}

TEST_CASE("Disengage fades the force within 50 ms, never a larger one than before") {
  LoopRun run(kWallScene);
  run.engage(kHome);
  for (int k = 0; k < 20; ++k) run.tick(pressed(0.004));
  double last = force(run.tick(pressed(0.004))).z();
  run.send(DisengageCommand{});
  for (int k = 0; k < 52; ++k) {
    const double now = force(run.tick(pressed(0.004))).z();
    CHECK(now <= last);
    last = now;
  }
  CHECK(last == 0.0);
}

TEST_CASE("a lost lease fades the force of a scripted device and the next pose brings it back") {
  LoopRun run(kWallScene);
  run.engage(kHome);
  for (int k = 0; k < 20; ++k) run.tick(pressed(0.002));
  run.send(LeaseLostCommand{});
  for (int k = 0; k < 52; ++k) run.tick();
  CHECK(force(run.tick()).isZero(0.0));
  CHECK(run.tick().tick.cause == Cause::kLeaseLost);
  for (int k = 0; k < 250; ++k) run.tick(kHome);
  CHECK(run.tick(kHome).tick.state == LoopState::kEngaged);
}

TEST_CASE("stiffness that changes in flight moves the force without a step") {
  LoopRun run(kWallScene);
  run.engage(kHome);
  for (int k = 0; k < 50; ++k) run.tick(pressed(0.001));
  const double before = force(run.tick(pressed(0.001))).z();
  auto change = std::make_unique<SettingsChange>();
  change->to = run.loop().scene().settings;
  change->from = change->to;
  change->to.tools[0].coupling.kt = 2000.0;
  run.change(std::move(change));
  double last = before;
  double largest_step = 0.0;
  int retired = 0;
  for (int k = 0; k < 60; ++k) {
    const ToldTick& told = run.tick(pressed(0.001));
    retired += count<SettingsRetired>(told);
    largest_step = std::max(largest_step, std::abs(force(told).z() - last));
    last = force(told).z();
  }
  CHECK(before == within(1.0, 1e-3));
  CHECK(last == within(2.0, 1e-3));
  // By equal factors, 50 of them: the last step is the largest.
  CHECK(largest_step < 2.0 * (1.0 - std::pow(2.0, -1.0 / 50.0)) + 1e-6);
  CHECK(largest_step <= 3.0 / 50.0 * (last - before));
  CHECK(retired == 1);
}

TEST_CASE("a change for a later tick waits for it") {
  LoopRun run(kWallScene);
  run.engage(kHome);
  for (int k = 0; k < 50; ++k) run.tick(pressed(0.001));
  auto change = std::make_unique<SettingsChange>();
  change->at_tick = run.loop().next_tick() + 30;
  change->to = run.loop().scene().settings;
  change->from = change->to;
  change->to.tools[0].coupling.kt = 2000.0;
  run.change(std::move(change));
  for (int k = 0; k < 30; ++k) {
    CHECK(force(run.tick(pressed(0.001))).z() == within(1.0, 1e-3));
  }
  CHECK(force(run.tick(pressed(0.001))).z() > 1.01);
}

TEST_CASE(
    "another scene is taken at once while virtual time stands still, and counts from tick 0") {
  LoopRun run(kWallScene);
  run.engage(kHome);
  run.swap_to(played_scene(kStringScene, 2));
  const ToldTick& told = run.tick(Vector3(0.0, 0.02, 0.0));
  CHECK(count<SceneSwapped>(told) == 1);
  CHECK(told.tick.scene_id == 2);
  CHECK(told.tick.tick == 0);
  CHECK(told.tick.t_ns == 0);
}

TEST_CASE(
    "under the real clock a scene is exchanged only after the force has faded, without a step") {
  LoopSetting setting;
  setting.real_time = true;
  LoopRun run(kWallScene, setting);
  run.engage(kHome);
  for (int k = 0; k < 20; ++k) run.tick(pressed(0.004));
  double last = force(run.tick(pressed(0.004))).z();
  REQUIRE(last > 3.0);
  run.swap_to(played_scene(kWallScene, 2, setting));
  int swapped = 0;
  for (int k = 0; k < 60 && swapped == 0; ++k) {
    const ToldTick& told = run.tick(pressed(0.004));
    swapped = count<SceneSwapped>(told);
    if (told.tick.scene_id != 1) break;
    CHECK(force(told).z() <= last);
    last = force(told).z();
  }
  CHECK(last == 0.0);
  for (int k = 0; k < 300; ++k) swapped += count<SceneSwapped>(run.tick(kHome));
  CHECK(swapped == 1);
  CHECK(run.tick(kHome).tick.scene_id == 2);
  CHECK(run.tick(kHome).tick.state == LoopState::kEngaged);
}

TEST_CASE(
    "a loop that stands still for 5 ms gets a zero wrench from the guardian, which it hears of") {
  for (const bool armed : {false, true}) {
    CAPTURE(armed);
    LoopSetting setting;
    setting.real_time = true;
    setting.guards_armed = armed;
    LoopRun run(kWallScene, setting);
    run.engage(kHome);
    for (int k = 0; k < 60; ++k) run.tick(pressed(0.004 * k / 59.0 - 0.02 * (59 - k) / 59.0));
    run.loop().guard(run.now_ns() + 4'900'000);
    CHECK(run.tick(pressed(0.004)).tick.state == LoopState::kEngaged);
    run.loop().guard(run.now_ns() + 5'100'000);
    const ToldTick& told = run.tick(pressed(0.004));
    // Where nobody can be pushed a stall is counted, not latched.
    CHECK(told.tick.state == (armed ? LoopState::kFault : LoopState::kEngaged));
    if (armed) CHECK(told.tick.cause == Cause::kGuardian);
  }
}

TEST_CASE(
    "a loop that stands still until the device's watchdog fires goes on where nobody is pushed") {
  for (const bool armed : {false, true}) {
    CAPTURE(armed);
    LoopRun run(kWallScene, {"simulated", "premium_3_0_6dof", armed, true});
    for (int k = 0; k < 400; ++k) run.tick();
    REQUIRE(run.tick().tick.state == LoopState::kEngaged);
    run.stand_still(100'000'000);
    bool fired = false;
    for (int k = 0; k < 10; ++k) {
      fired = fired || (run.tick().tick.tools[0].sample.flags & kDeviceWatchdogFired) != 0;
    }
    CHECK(fired);
    const Tick& after = run.tick().tick;
    CHECK(after.state == (armed ? LoopState::kFault : LoopState::kEngaged));
    if (armed) CHECK(after.cause == Cause::kDeviceWatchdog);
    CHECK((after.tools[0].sample.flags & kDeviceWatchdogFired) == 0);
  }
}

TEST_CASE("each stage of a tick has its time under the real clock, and none in virtual time") {
  for (const bool real_time : {false, true}) {
    CAPTURE(real_time);
    LoopSetting setting;
    setting.real_time = real_time;
    LoopRun run(kWallScene, setting);
    run.engage(kHome);
    const StageTimes stages = run.tick(pressed(0.004)).tick.times.stages;
    const bool any = stages != StageTimes{};
    const bool all = std::all_of(stages.begin(), stages.end(), [](auto ns) { return ns > 0; });
    CHECK(any == real_time);
    CHECK(all == real_time);
  }
}

TEST_CASE("a drag over a string sounds once, at an instant within the last four ticks") {
  LoopRun run(kStringScene);
  run.engage(Vector3(0.0, 0.004, -0.02));
  int tones = 0;
  for (int k = 0; k < 200; ++k) {
    const ToldTick& told = run.tick(Vector3(0.0, 0.0046, -0.02 + 0.0002 * k));
    for (const LoopEvent& event : told.events) {
      const auto* string = std::get_if<StringEvent>(&event.what);
      if (string == nullptr || string->kind != StringEventKind::kTone) continue;
      ++tones;
      CHECK(string->t_ns <= told.tick.t_ns);
      CHECK(string->t_ns > told.tick.t_ns - 4'000'000);
    }
  }
  CHECK(tones == 1);
}

TEST_CASE("contacts of bodies begin once and end once per touch") {
  LoopRun run(kWallScene);
  run.engage(kHome);
  int begins = 0;
  int ends = 0;
  for (int touch = 0; touch < 3; ++touch) {
    for (int k = 0; k < 60; ++k) {
      const double depth = 0.002 * std::sin(3.14159265358979 * k / 30.0);
      const ToldTick& told = run.tick(pressed(depth));
      for (const LoopEvent& event : told.events) {
        const auto* body = std::get_if<TouchEvent>(&event.what);
        if (body == nullptr) continue;
        (body->begins ? begins : ends) += 1;
        CHECK(body->nhat_OG_W[2] == doctest::Approx(1.0));
      }
    }
  }
  CHECK(begins == 3);
  CHECK(ends == 3);
}

TEST_CASE("the same poses give the same bits") {
  const auto play = [] {
    LoopRun run(kStringScene);
    std::vector<double> numbers;
    for (int k = 0; k < 600; ++k) {
      const ToldTick& told =
          run.tick(Vector3(0.01 * std::sin(0.01 * k), 0.0046, -0.02 + 0.0001 * k));
      for (const double f : told.tick.tools[0].F_written_H_W.f) numbers.push_back(f);
      for (const double p : told.tick.tools[0].X_WG.p) numbers.push_back(p);
    }
    return numbers;
  };
  CHECK(play() == play());
}

TEST_CASE("a tick leaves the heap alone, whatever it is told") {
  LoopRun run(kStringScene);
  run.engage(Vector3(0.0, 0.004, -0.02));
  std::int64_t touched = 0;
  for (int k = 0; k < 300; ++k) {
    TickPose pose;
    pose.tick = run.loop().next_tick();
    pose.pose.p_DH = {0.0, 0.0046, -0.02 + 0.0002 * k};
    run.channels().poses.push(pose);
    if (k == 100) run.send(DisengageCommand{});
    if (k == 200) run.send(EngageCommand{});
    if (k == 250) run.send(StopCommand{});
    const NoHeapScope scope;
    run.loop().tick_once(0);
    touched += scope.count();
    LoopEvent event;
    while (run.channels().events.pop(event)) {
    }
    const auto told = std::make_unique<Tick>();
    while (run.channels().ticks.pop(*told)) {
    }
  }
  CHECK(touched == 0);
}

TEST_CASE("after End the loop is over within 50 ms and writes nothing more") {
  LoopRun run(kWallScene);
  run.engage(kHome);
  for (int k = 0; k < 20; ++k) run.tick(pressed(0.004));
  run.send(EndCommand{});
  for (int k = 0; k < 52; ++k) run.tick(pressed(0.004));
  CHECK(run.loop().over());
  CHECK(force(run.tick(pressed(0.004))).isZero(0.0));
}

}  // namespace hapticd::test
