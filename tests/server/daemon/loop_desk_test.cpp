// What the desk lends to the loop and takes back, and how commands without room are refused.
#include "server/daemon/loop_desk.h"

#include <doctest/doctest.h>

#include <memory>
#include <optional>
#include <vector>

#include "tests/server/haptic_loop/loop_run.h"

namespace hapticd::test {
namespace {

constexpr const char* kScene = R"(
name: "wall"
tools {
  name: "finger"
  parts { name: "tip" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } }
  pose_wg { p_m: [0, 0, 0.025] }
}
bodies { name: "wall" shape { spheres { centre_m: [0, 0, -1000] radius_m: 1000 } } }
)";

/// A desk whose loop plays with a simulated hand, and what the loop has told.
struct Bench {
  explicit Bench(bool stepped_here) : desk(clients, stepped_here) {
    LoopSetting setting;
    setting.source = "simulated";
    setting.profile = "premium_3_0_6dof";
    LoopOptions options;
    options.virtual_time = stepped_here;
    desk.begin(options, played_scene(kScene, 1, setting),
               [this](const LoopEvent& event) { told.push_back(event); });
  }
  void tick() {
    desk.loop().tick_once(now_ns += 1'000'000);
    desk.take_events();
    while (desk.channels().ticks.pop(*tick_told)) {
    }
  }
  [[nodiscard]] std::unique_ptr<SettingsChange> change() {
    const SceneSettings& now = desk.loop().scene().settings;
    return std::make_unique<SettingsChange>(SettingsChange{0, 0, now, now});
  }

  ServedClients clients;
  LoopDesk desk;
  std::vector<LoopEvent> told;
  std::unique_ptr<Tick> tick_told = std::make_unique<Tick>();
  std::int64_t now_ns = 1'000'000'000;
};

v1::ResultCode code_of(const Answer& answer) {
  return answer ? answer->code() : v1::RESULT_CODE_UNSPECIFIED;
}

}  // namespace

TEST_CASE("commands beyond what the loop can hold are refused, until it has obeyed some") {
  Bench bench(false);
  const std::size_t room = bench.desk.channels().commands.capacity();
  for (std::size_t k = 0; k < room; ++k) REQUIRE(!bench.desk.command({1, k}, ClutchCommand{}));
  const std::uint64_t number = bench.desk.next_number();
  CHECK(code_of(bench.desk.command({1, room}, ClutchCommand{})) == v1::RESULT_CODE_BUSY);
  CHECK(code_of(bench.desk.lend({1, room}, std::make_unique<GesturePlan>())) ==
        v1::RESULT_CODE_BUSY);
  CHECK(code_of(bench.desk.lend(std::nullopt, bench.change())) == v1::RESULT_CODE_BUSY);
  CHECK(bench.desk.next_number() == number + 3);
  bench.tick();
  CHECK(!bench.desk.command({1, room}, ClutchCommand{}));
}

TEST_CASE("what is lent for ever comes back for ever, and makes room for more") {
  Bench bench(true);
  const std::size_t room = bench.desk.channels().gestures.lent.capacity();
  for (std::size_t k = 0; k < 3 * room; ++k) {
    REQUIRE(!bench.desk.lend({1, k}, std::make_unique<GesturePlan>()));
    REQUIRE(!bench.desk.lend(RequestId{2, k}, bench.change()));
    bench.tick();
  }
}

TEST_CASE("without a tick no more is lent than can come back") {
  Bench bench(false);
  for (std::size_t k = 0; k < 3; ++k) {
    LoopSetting setting;
    setting.source = "simulated";
    setting.profile = "premium_3_0_6dof";
    REQUIRE(!bench.desk.lend(RequestId{1, k}, played_scene(kScene, 2, setting), ""));
  }
  CHECK(code_of(bench.desk.lend(RequestId{1, 3}, played_scene(kScene, 2, {}), "")) ==
        v1::RESULT_CODE_BUSY);
}

}  // namespace hapticd::test
