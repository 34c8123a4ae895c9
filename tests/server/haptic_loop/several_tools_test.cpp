// Several tools in one loop: each has a device, a map and a wrench of its own, and all get force
// together.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <vector>

#include "tests/server/haptic_loop/loop_run.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr int kTools = 3;
using Handles = std::array<Vector3, kTools>;

/// Handles before the wall, each as deep in it as said (negative: before it).
Handles at_depths(double first, double second, double third) {
  return {Vector3(-0.1, 0.0, 0.005 - first), Vector3(0.0, 0.0, 0.005 - second),
          Vector3(0.1, 0.0, 0.005 - third)};
}

const double kFree = -0.02;

void engage(LoopRun& run) {
  for (int k = 0; k < 250; ++k) run.tick_all(at_depths(kFree, kFree, kFree));
  REQUIRE(run.tick_all(at_depths(kFree, kFree, kFree)).tick.state == LoopState::kEngaged);
}

/// Until the wrench has followed.
const ToldTick& hold(LoopRun& run, const Handles& handles) {
  for (int k = 0; k < 20; ++k) run.tick_all(handles);
  return run.tick_all(handles);
}

}  // namespace

TEST_CASE("each of several tools feels its own contact, with its own stiffness") {
  LoopRun run(kThreeFingerScene);
  engage(run);
  const ToldTick& told = hold(run, at_depths(0.001, 0.002, kFree));
  REQUIRE(told.tick.tools.size() == kTools);
  CHECK(told.tick.tools[0].tool_id == 7);
  CHECK(told.tick.tools[1].tool_id == 2);
  CHECK(told.tick.tools[2].tool_id == 30);
  // Stiffness times depth: 1000 N/m, 500 N/m, and nothing. The wall, a ball
  // of 1 km, falls off by x^2 / 2 r = 5 um at the first.
  CHECK(force(told, 0).z() == within(0.995, 1e-4));
  CHECK(force(told, 1).z() == within(1.0, 1e-4));
  CHECK(force(told, 2).isZero(0.0));
  CHECK(told.tick.tools[0].contacts == 1);
  CHECK(told.tick.tools[1].contacts == 1);
  CHECK(told.tick.tools[2].contacts == 0);
  CHECK(told.tick.contacts_total == 2);
}

TEST_CASE(
    "a bad pose of one tool takes the force from all of them, and it is the one that is named") {
  LoopRun run(kThreeFingerScene);
  engage(run);
  hold(run, at_depths(0.002, 0.002, 0.002));
  Handles bad = at_depths(0.002, 0.002, 0.002);
  bad[1].y() = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::uint32_t> blamed;
  for (int k = 0; k < 3; ++k) {
    for (const LoopEvent& event : run.tick_all(bad).events) {
      if (std::holds_alternative<FaultNotice>(event.what)) blamed.push_back(event.tool_id);
    }
  }
  CHECK(blamed == std::vector<std::uint32_t>{2});
  const ToldTick& told = run.tick_all(at_depths(0.002, 0.002, 0.002));
  CHECK(told.tick.cause == Cause::kNotFinite);
  for (std::size_t k = 0; k < kTools; ++k) CHECK(force(told, k).isZero(0.0));
}

TEST_CASE("no tool gets force before all of them are free") {
  LoopRun run(kThreeFingerScene);
  for (int k = 0; k < 20; ++k) {
    const ToldTick& told = run.tick_all(at_depths(kFree, kFree, 0.001));
    for (std::size_t tool = 0; tool < kTools; ++tool) CHECK(force(told, tool).isZero(0.0));
    if (k > 2) CHECK(told.tick.cause == Cause::kOverlap);
  }
  engage(run);
}

TEST_CASE("Recentre and Clutch are for the tool they name") {
  LoopRun run(kThreeFingerScene);
  engage(run);
  run.send(ClutchCommand{1, true});
  Handles handles = at_depths(kFree, kFree, kFree);
  run.tick_all(handles);
  for (Vector3& p_WH : handles) p_WH.y() += 0.01;
  const ToldTick& told = hold(run, handles);
  CHECK(told.tick.tools[0].X_WH.p[1] == doctest::Approx(0.01));
  CHECK(told.tick.tools[1].X_WH.p[1] == 0.0);
  CHECK(told.tick.tools[2].X_WH.p[1] == doctest::Approx(0.01));
  CHECK((told.tick.tools[1].flags & kClutched) != 0);
  CHECK((told.tick.tools[0].flags & kClutched) == 0);
  run.send(ClutchCommand{1, false});
  run.send(RecentreCommand{2});
  const ToldTick& recentred = hold(run, handles);
  CHECK(recentred.tick.tools[0].X_WH.p[1] == doctest::Approx(0.01));
  CHECK(std::abs(recentred.tick.tools[2].X_WH.p[1]) < 1e-12);
}

TEST_CASE("each scripted tool holds its own last pose when its poses end") {
  LoopRun run(kThreeFingerScene);
  engage(run);
  hold(run, at_depths(kFree, kFree, kFree));
  const Vector3 first(-0.1, 0.05, 0.025);
  for (int k = 0; k < 5; ++k) run.tick_all({&first, 1});
  const ToldTick& told = run.tick_all({&first, 1});
  CHECK(told.tick.tools[0].X_WH.p[1] == 0.05);
  CHECK(told.tick.tools[1].X_WH.p[0] == 0.0);
  CHECK(told.tick.tools[2].X_WH.p[0] == 0.1);
}

TEST_CASE("what the recorder is told of several tools is what the network is told") {
  LoopRun run(kThreeFingerScene);
  engage(run);
  const ToldTick& told = hold(run, at_depths(0.001, kFree, 0.003));
  auto trace = std::make_unique<Tick>();
  while (run.channels().recorded.pop(*trace)) {
  }
  // The ring holds all of this run.
  REQUIRE(trace->tick == told.tick.tick);
  REQUIRE(trace->tools.size() == kTools);
  for (std::size_t k = 0; k < kTools; ++k) {
    CHECK(trace->tools[k].tool_id == told.tick.tools[k].tool_id);
    CHECK(trace->tools[k].F_written_H_W.f == told.tick.tools[k].F_written_H_W.f);
    CHECK(trace->tools[k].X_WG.p == told.tick.tools[k].X_WG.p);
  }
}

}  // namespace hapticd::test
