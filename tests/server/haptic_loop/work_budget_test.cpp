// The work that a loop is allowed: from which tick on, what is told of it, and when it ends. Truth:
// the counts themselves.
#include <doctest/doctest.h>

#include "tests/server/haptic_loop/loop_run.h"

namespace hapticd::test {
namespace {

/// Above the string, and beneath it.
const Vector3 kAbove{0.0, 0.02, 0.0};
const Vector3 kBeneath{0.003, -0.02, 0.002};
/// Units of work that half a tick of 1 ms is worth under the virtual clock: 500 us and the 2 % that
/// are allowed beyond, at 1.4 ns each.
constexpr std::uint64_t kHalfTick = 364'285;

}  // namespace

TEST_CASE("with nothing said no tick is without a bound, from the first of a scene on") {
  LoopRun run(kStringScene);
  CHECK(run.tick(kAbove).tick.budget.work == kHalfTick);
  CHECK(run.tick(kBeneath).tick.budget.work == kHalfTick);
  run.swap_to(played_scene(kWallScene, 2));
  CHECK(run.tick(kAbove).tick.budget.work == kHalfTick);
}

TEST_CASE("under the real clock the first ticks get what fits at the guessed price, and no more") {
  LoopSetting setting;
  setting.real_time = true;
  LoopRun usual(kStringScene, setting);
  const std::uint64_t work = usual.tick(kAbove).tick.budget.work;
  CHECK(work > 0);
  // Even where a unit costs thrice what it did where the weights are from.
  CHECK(3.0 * 1.4 * static_cast<double>(work) <= 500e3);
  setting.budget_us = 1e6;
  CHECK(LoopRun(kStringScene, setting).tick(kAbove).tick.budget.work > 1000 * work);
  setting.budget_us = 0.0;
  CHECK(LoopRun(kStringScene, setting).tick(kAbove).tick.budget.work == 0);
}

TEST_CASE("a scene with automatic quality begins with the bound of its own budget") {
  const std::string scene = std::string(kStringScene) + "quality { automatic { budget_us: 70 } }";
  LoopSetting setting;
  for (const double budget_us : {0.0, 500.0, 1e6}) {
    setting.budget_us = budget_us;
    CHECK(LoopRun(scene, setting).tick(kAbove).tick.budget.work == 51'000);
  }
}

TEST_CASE(
    "from the tick that hears of a work budget on no tick goes beyond it by more than a step") {
  LoopSetting setting;
  setting.budget_us = 0.0;
  LoopRun run(kStringScene, setting);
  run.engage(kAbove);
  const Tick& unbounded = run.tick(kBeneath).tick;
  CHECK(unbounded.budget.work == 0);
  const WorkTick free = unbounded.work;
  CHECK_FALSE(free.cut_short);
  REQUIRE(free.sub_steps > 3);
  REQUIRE(free.work > 3000);

  run.tick(kAbove);
  run.send(WorkBudgetCommand{1});
  const Tick& bounded = run.tick(kBeneath).tick;
  CHECK(bounded.budget.work == 1);
  const WorkTick least = bounded.work;
  CHECK(least.cut_short);
  CHECK(least.sub_steps == 1);
  CHECK(2 * least.work < free.work);

  run.tick(kAbove);
  run.send(WorkBudgetCommand{0});
  CHECK(run.tick(kBeneath).tick.budget.work == 0);
}

TEST_CASE("a budget below zero is none, and a new scene begins with the one it was made with") {
  LoopRun run(kStringScene);
  run.engage(kAbove);
  run.send(WorkBudgetCommand{-5});
  CHECK(run.tick(kAbove).tick.budget.work == 0);
  run.send(WorkBudgetCommand{700});
  CHECK(run.tick(kAbove).tick.budget.work == 700);
  LoopSetting setting;
  setting.budget_us = 70.0;
  run.swap_to(played_scene(kWallScene, 2, setting));
  CHECK(run.tick(kAbove).tick.budget.work == 51'000);
}

}  // namespace hapticd::test
