// What a Clear mends, and what goes with a lost lease.
#include <doctest/doctest.h>

#include <limits>

#include "server/haptic_loop/haptic_loop.h"
#include "tests/server/haptic_loop/loop_run.h"

namespace hapticd::test {
namespace {

/// Of the finger's centre when it touches the wall.
constexpr double kTouch = 0.005;
const Vector3 kHome(0.0, 0.0, 0.025);

Vector3 pressed(double depth) { return {0.0, 0.0, kTouch - depth}; }

}  // namespace

TEST_CASE("Clear mends a simulated hand whose numbers have gone, and force comes back") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  LoopSetting setting;
  setting.source = "simulated";
  setting.profile = "premium_3_0_6dof";
  for (const bool gesture_first : {false, true}) {
    LoopRun run(kWallScene, setting);
    for (int k = 0; k < 250; ++k) run.tick();
    REQUIRE(run.tick().tick.state == LoopState::kEngaged);
    GesturePlan gone;
    gone.motions.resize(1);
    gone.motions[0].legs.resize(2);
    gone.motions[0].legs[1].point.p_DH = {nan, 0.0, 0.0};
    run.play(std::make_unique<GesturePlan>(gone));
    for (int k = 0; k < 2000 && run.tick().tick.state != LoopState::kFault; ++k) {
    }
    REQUIRE(run.tick().tick.cause == Cause::kNotFinite);
    for (int k = 0; k < 50; ++k) CHECK(force(run.tick()).isZero(0.0));
    if (gesture_first) {
      auto rest = std::make_unique<GesturePlan>();
      rest->arm = ArmKind::kLight;
      run.play(std::move(rest));
      CHECK(run.tick().tick.state == LoopState::kFault);
    }
    run.send(ClearCommand{});
    const ToldTick& cleared = run.tick();
    CHECK(count<CommandDone>(cleared) == 1);
    CHECK(cleared.tick.state != LoopState::kFault);
    for (int k = 0; k < 250; ++k) run.tick();
    CHECK(run.tick().tick.state == LoopState::kEngaged);
  }
}

TEST_CASE("Clear is refused while the poses of a script are no numbers") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  LoopRun run(kWallScene);
  run.engage(kHome);
  for (int k = 0; k < 10; ++k) run.tick(Vector3(0.0, nan, 0.0));
  run.send(ClearCommand{});
  CHECK(count<CommandRefused>(run.tick(Vector3(0.0, nan, 0.0))) == 1);
}

TEST_CASE("poses that were under way when the lease was lost are not followed") {
  LoopRun run(kWallScene);
  run.engage(kHome);
  const auto give = [&](std::uint64_t ahead, std::uint64_t lease, const Vector3& p_WH) {
    TickPose pose;
    pose.tick = run.loop().next_tick() + ahead;
    pose.lease = lease;
    pose.pose.p_DH = to_array(p_WH);
    REQUIRE(run.channels().poses.push(pose));
  };
  // More than one tick takes over, so that most are still under way when the lease is lost.
  for (std::uint64_t k = 1; k <= 200; ++k) give(k, 0, pressed(0.004));
  run.send(LeaseLostCommand{1});
  for (int k = 0; k < 300; ++k) CHECK(run.tick().tick.tools[0].X_WH.p == to_array(kHome));
  give(0, 1, pressed(0.004));
  CHECK(run.tick().tick.tools[0].X_WH.p == to_array(pressed(0.004)));
}

TEST_CASE("a lost lease takes the changes with it that wait for their tick, and those alone") {
  LoopRun run(kWallScene);
  run.engage(kHome);
  for (int k = 0; k < 50; ++k) run.tick(pressed(0.001));
  const auto send_change = [&](std::uint64_t ahead, double kt) {
    auto change = std::make_unique<SettingsChange>();
    change->at_tick = ahead == 0 ? 0 : run.loop().next_tick() + ahead;
    change->to = run.loop().scene().settings;
    change->from = change->to;
    change->to.tools[0].coupling.kt = kt;
    run.change(std::move(change));
  };
  send_change(0, 500.0);
  send_change(20, 2000.0);
  send_change(1'000'000, 4000.0);
  run.send(LeaseLostCommand{1});
  int dropped = 0;
  const auto note = [&](const ToldTick& told) {
    for (const LoopEvent& event : told.events) {
      const auto* retired = std::get_if<SettingsRetired>(&event.what);
      dropped += retired != nullptr && retired->dropped ? 1 : 0;
    }
  };
  for (int k = 0; k < 120; ++k) note(run.tick(pressed(0.001)));
  CHECK(dropped == 2);
  CHECK(run.loop().scene().settings.tools[0].coupling.kt == 500.0);
}

}  // namespace hapticd::test
