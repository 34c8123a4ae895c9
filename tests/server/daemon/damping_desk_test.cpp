// The request to measure a damping, from the loop's start of it to what the device's record says.
// Truth: the handle's own numbers (tests/support/ringing_handle.h).
#include "server/daemon/damping_desk.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <memory>

#include "device/attach/damping_record.h"
#include "server/haptic_loop/settings_change.h"
#include "tests/device/attach/check_folder.h"
#include "tests/server/haptic_loop/loop_run.h"
#include "tests/server/haptic_loop/ringing_device.h"

namespace hapticd::test {
namespace {

constexpr PushAxis kAlongZ = 5;

/// A loop that plays the wall with a device that rings, the desk, and the check of the device.
class DampingBench {
 public:
  explicit DampingBench(const HandleTruth& truth) {
    LoopOptions options;
    options.virtual_time = true;
    RingingScene scene(truth, 1e-9 * static_cast<double>(options.period_ns));
    handle = scene.handle;
    apply_settings(*scene.played);
    subject.device = checked_device(pen("S1"), kStated, AxisMapping{});
    subject.can_push = {false, false, true};
    check = std::make_unique<DeviceCheck>(subject, folder.path());
    loop.begin(options, std::move(scene.played),
               [this](const LoopEvent& event) { desk.take(event); });
    run(5);
  }

  void run(int ticks) {
    for (int k = 0; k < ticks; ++k) {
      loop.loop().tick_once(0);
      loop.take_events();
      while (loop.channels().ticks.pop(*told_)) {
        loop.note(*told_);
        desk.take(*told_);
      }
    }
  }
  void engage() {
    REQUIRE(loop.post(EngageCommand{}));
    for (int k = 0; k < 3000 && loop.state() != LoopState::kEngaged; ++k) run(1);
    run(250);
    REQUIRE(loop.state() == LoopState::kEngaged);
  }
  /// Asks, and lets the handle go.
  void begin() {
    CHECK_FALSE(desk.begin({}, {0, kAlongZ}, *check).has_value());
    CHECK(desk.busy());
    handle->free = true;
  }
  /// Ticks until it is over.
  int finish() {
    int ticks = 0;
    while (desk.busy() && ticks < 20'000) run(1), ++ticks;
    return ticks;
  }
  [[nodiscard]] bool is_kept() const {
    return std::filesystem::exists(damping_file(folder.path(), subject.device));
  }

  CheckFolder folder;
  CheckSubject subject;
  std::unique_ptr<DeviceCheck> check;
  ServedClients clients;
  LoopDesk loop{clients, true};
  DampingDesk desk{loop, clients};
  RingingDevice* handle = nullptr;

 private:
  std::unique_ptr<Tick> told_ = std::make_unique<Tick>();
};

}  // namespace

TEST_CASE("a measuring that was asked for ends in the device's record, below the true damping") {
  HandleTruth truth;
  truth.step = 2e-5;
  DampingBench bench(truth);
  bench.engage();
  bench.begin();
  const int ticks = bench.finish();
  CHECK(ticks > 1000 * kMeasuring_s);
  CHECK(ticks < 8000);
  const MeasuredDamping kept = read_damping(bench.folder.path(), bench.subject.device);
  REQUIRE(kept[2]);
  CHECK(kept[2]->lower > 0.5 * truth.damping);
  CHECK(kept[2]->lower <= truth.damping);
  CHECK(kept[2]->upper >= truth.damping);
  CHECK_FALSE(kept[0]);
  REQUIRE(bench.check->damping()[2]);
  CHECK(bench.check->damping()[2]->lower == kept[2]->lower);
}

TEST_CASE("a hand on the handle leaves no record, and another measuring may follow") {
  HandleTruth held;
  held.hand_mass = 0.1;
  held.hand_damping = 3.0;
  held.hand_stiffness = 150.0;
  DampingBench bench(held);
  bench.engage();
  for (int k = 0; k < 2; ++k) {
    bench.begin();
    bench.finish();
    CHECK_FALSE(bench.desk.busy());
    CHECK_FALSE(bench.is_kept());
  }
}

TEST_CASE("a measuring without force is refused, one that is cut short finds nothing") {
  DampingBench bench(HandleTruth{});
  bench.begin();
  CHECK(bench.finish() < 5);
  bench.engage();
  bench.begin();
  bench.run(1000);
  CHECK(bench.desk.busy());
  REQUIRE(bench.loop.post(StopCommand{}));
  CHECK(bench.finish() < 10);
  CHECK_FALSE(bench.desk.busy());
  CHECK_FALSE(bench.is_kept());
}

TEST_CASE("each end of a step of a check is told by its code, with its words") {
  const auto told = [](CheckVerdict verdict) { return to_result({verdict, "words"}); };
  CHECK(told(CheckVerdict::kRight).code() == v1::RESULT_CODE_OK);
  CHECK(told(CheckVerdict::kFeltWrong).code() == v1::RESULT_CODE_INVALID);
  CHECK(told(CheckVerdict::kNoPush).code() == v1::RESULT_CODE_WRONG_STATE);
  CHECK(told(CheckVerdict::kNotKept).code() == v1::RESULT_CODE_FAILED);
  CHECK(told(CheckVerdict::kNotMeasured).code() == v1::RESULT_CODE_FAILED);
  CHECK(told(CheckVerdict::kNotMeasured).message() == "words");
}

}  // namespace hapticd::test
