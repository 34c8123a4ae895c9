// The work that a loop is allowed: from which tick on, what is told of it, and when it ends. Truth:
// the counts themselves.
#include <doctest/doctest.h>

#include "tests/server/haptic_loop/loop_run.h"

namespace hapticd::test {
namespace {

/// Above the string, and beneath it.
const Vector3 kAbove{0.0, 0.02, 0.0};
const Vector3 kBeneath{0.003, -0.02, 0.002};

}  // namespace

TEST_CASE(
    "from the tick that hears of a work budget on no tick goes beyond it by more than a step") {
  LoopRun run(kStringScene);
  run.engage(kAbove);
  const TickWork free = run.tick(kBeneath).snapshot.work;
  CHECK(free.work_budget == 0);
  CHECK_FALSE(free.cut_short);
  REQUIRE(free.sub_steps > 3);
  REQUIRE(free.work > 3000);

  run.tick(kAbove);
  run.send(WorkBudgetCommand{1});
  const TickWork least = run.tick(kBeneath).snapshot.work;
  CHECK(least.work_budget == 1);
  CHECK(least.cut_short);
  CHECK(least.sub_steps == 1);
  CHECK(2 * least.work < free.work);

  run.tick(kAbove);
  run.send(WorkBudgetCommand{0});
  CHECK(run.tick(kBeneath).snapshot.work.work_budget == 0);
}

TEST_CASE("a budget below zero is none, and a new scene begins without one") {
  LoopRun run(kStringScene);
  run.engage(kAbove);
  run.send(WorkBudgetCommand{-5});
  CHECK(run.tick(kAbove).snapshot.work.work_budget == 0);
  run.send(WorkBudgetCommand{700});
  CHECK(run.tick(kAbove).snapshot.work.work_budget == 700);
  run.send(SwapSceneCommand{played_scene(kWallScene, 2).release()});
  CHECK(run.tick(kAbove).snapshot.work.work_budget == 0);
}

}  // namespace hapticd::test
