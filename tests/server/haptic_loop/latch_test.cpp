// What latches, and what ends it: for every cause there is, one that makes a fault ends when its
// cause is gone and a Clear has been heard, and the force comes back; the others make none. Truth:
// the finger in the wall feels stiffness times depth again.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <optional>

#include "server/haptic_loop/haptic_loop.h"
#include "tests/server/haptic_loop/loop_run.h"

namespace hapticd::test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
/// Of the finger's centre when it touches the wall, m; and where it is without contact.
constexpr double kTouch = 0.005;
constexpr double kHome = 0.025;
/// In the wall, and the least it then feels at 1000 N/m.
constexpr double kDepth = 0.004;
constexpr double kFelt = 3.9;

/// A device that does what it is told, and whatever is to be wrong with it.
class TestHandle final : public HapticDevice {
 public:
  TestHandle() { profile_.peak_force = 20.0; }

  [[nodiscard]] const DeviceProfile& profile() const noexcept override { return profile_; }
  ReadOutcome read(std::int64_t now_ns, DeviceSample& sample) noexcept override {
    if (outcome != ReadOutcome::kFresh) return outcome;
    ++counter_;
    // A hand trembles.
    if (!frozen) sample.p_DH = {0.0, 1e-7 * static_cast<double>(counter_ % 7), z + no_number};
    sample.t_ns = now_ns;
    sample.counter = counter_;
    sample.flags = flags;
    return outcome;
  }
  bool write(std::int64_t /*now_ns*/, const DeviceCommand& command) noexcept override {
    if (command.clear_faults) {
      flags &= static_cast<std::uint16_t>(~(kDeviceReportsFault | kDeviceWatchdogFired));
    }
    return writes;
  }
  void write_zero(std::int64_t /*now_ns*/) noexcept override { ++zeros; }

  double z = kHome;
  double no_number = 0.0;  ///< NaN: the pose is none
  bool frozen = false;
  bool writes = true;
  ReadOutcome outcome = ReadOutcome::kFresh;
  std::uint16_t flags = kDeviceAttached | kDeviceCalibrated;
  int zeros = 0;

 private:
  DeviceProfile profile_;
  std::uint64_t counter_ = 0;
};

/// A loop with every guard armed that plays this handle before the wall.
class Bench {
 public:
  Bench() {
    std::unique_ptr<PlayedScene> played =
        played_scene(kWallScene, 1, {"scripted", "ideal", true, true});
    auto made = std::make_unique<TestHandle>();
    handle = made.get();
    PlayedDevice place;
    place.traits.can_push_a_person = false;
    place.device = handle;
    place.owned = std::move(made);
    played->tools[0].device = std::move(place);
    LoopOptions options;
    options.guards_armed = true;
    loop_.emplace(options, std::move(played), *channels_);
  }

  void tick(std::uint64_t skipped = 0) {
    now_ns_ += 1'000'000 * (1 + static_cast<std::int64_t>(skipped));
    loop_->tick_once(now_ns_, skipped);
    while (channels_->ticks.pop(*told_)) {
    }
    if (!events_wait) take_events();
  }
  void take_events() {
    LoopEvent event;
    while (channels_->events.pop(event)) {
    }
  }
  void run(int ticks) {
    for (int k = 0; k < ticks; ++k) tick();
  }
  void send(const LoopCommandBody& what) { REQUIRE(channels_->commands.push({1, what})); }
  /// Away from the wall until force is on, then into it.
  void press() {
    handle->z = kHome;
    run(300);
    for (int k = 1; k <= 40; ++k) {
      handle->z = kHome + (kTouch - kDepth - kHome) * k / 40;
      tick();
    }
    run(20);
  }
  /// What goes from tick to tick of the tool in the simulation is no number any more.
  void poison() { loop_->scene().play.tools[0].state.contact.X_WG.p.setConstant(kNan); }
  void stall() { loop_->guard(now_ns_ + kStall_ns + 1'000'000); }
  [[nodiscard]] double force() const { return to_vector(told_->tools[0].F_written_H_W.f).norm(); }
  [[nodiscard]] LoopState state() const { return told_->state; }
  [[nodiscard]] Cause cause() const { return told_->cause; }

  TestHandle* handle = nullptr;
  bool events_wait = false;  ///< nobody takes them

 private:
  std::unique_ptr<LoopChannels> channels_ = std::make_unique<LoopChannels>();
  std::optional<HapticLoop> loop_;
  std::unique_ptr<Tick> told_ = std::make_unique<Tick>();
  std::int64_t now_ns_ = 1'000'000'000;
};

using Action = std::function<void(Bench&)>;

/// How a cause is brought about, tick by tick until it is seen, and how it ends.
struct Case {
  Action inject;
  Action end = [](Bench&) {};
};

void jump(Bench& bench) {
  bench.handle->z += 0.05;
  bench.tick();
}

void lose_events(Bench& bench) {
  bench.events_wait = true;
  for (int k = 0; k < kCommandsPerTick; ++k) bench.send(ClutchCommand{0, false});
  bench.tick();
}

void stop(Bench& bench) {
  bench.send(StopCommand{});
  bench.tick();
}

void spoil(Bench& bench) {
  bench.handle->no_number = kNan;
  bench.tick();
}

void freeze(Bench& bench) {
  bench.handle->frozen = true;
  bench.tick();
}

void stall(Bench& bench) {
  bench.stall();
  bench.tick();
}

void refuse(Bench& bench) {
  bench.handle->writes = false;
  bench.tick();
}

void lose_zero(Bench& bench) {
  bench.handle->flags &= static_cast<std::uint16_t>(~kDeviceCalibrated);
  bench.tick();
}

/// Those that make a fault; the rest of the table is empty.
std::array<std::optional<Case>, kMaxCause + 1> latching_cases() {
  std::array<std::optional<Case>, kMaxCause + 1> cases;
  const auto set = [&](Cause cause, Case made) {
    cases[static_cast<std::size_t>(cause)] = std::move(made);
  };
  const auto raise = [](std::uint16_t flag) {
    return [flag](Bench& bench) {
      bench.handle->flags |= flag;
      bench.tick();
    };
  };
  const auto lower = [](std::uint16_t flag) {
    return [flag](Bench& bench) { bench.handle->flags &= static_cast<std::uint16_t>(~flag); };
  };
  const auto read_as = [](ReadOutcome outcome) {
    return [outcome](Bench& bench) {
      bench.handle->outcome = outcome;
      bench.tick();
    };
  };
  const Action read_again = [](Bench& bench) { bench.handle->outcome = ReadOutcome::kFresh; };
  set(Cause::kStopped, {stop});
  set(Cause::kNotFinite, {spoil, [](Bench& bench) { bench.handle->no_number = 0.0; }});
  set(Cause::kInputStale, {read_as(ReadOutcome::kNothing), read_again});
  set(Cause::kInputStuck, {freeze, [](Bench& bench) { bench.handle->frozen = false; }});
  set(Cause::kVelocityTrip, {jump});
  set(Cause::kOverrun,
      {[](Bench& bench) { bench.tick(1); }, [](Bench& bench) { bench.run(1100); }});
  set(Cause::kGuardian, {stall});
  set(Cause::kDeviceLost, {read_as(ReadOutcome::kLost), read_again});
  set(Cause::kDeviceFault, {raise(kDeviceReportsFault)});
  set(Cause::kDeviceWrite, {refuse, [](Bench& bench) { bench.handle->writes = true; }});
  set(Cause::kDeviceWatchdog, {raise(kDeviceWatchdogFired)});
  set(Cause::kEmergencyStop, {raise(kDeviceEmergencyStop), lower(kDeviceEmergencyStop)});
  set(Cause::kNotCalibrated,
      {lose_zero, [](Bench& bench) { bench.handle->flags |= kDeviceCalibrated; }});
  set(Cause::kEventOverflow, {lose_events, [](Bench& bench) {
                                bench.events_wait = false;
                                bench.take_events();
                              }});
  return cases;
}

/// Those that keep a loop from engaging, or that it is never told: no fault.
constexpr std::array kNoFaults{Cause::kLeaseLost, Cause::kDeadMan,       Cause::kNotChecked,
                               Cause::kOverlap,   Cause::kReplayDiffers, Cause::kInjected,
                               Cause::kReleased};

}  // namespace

TEST_CASE("every cause that latches ends with itself and a Clear, and force comes back") {
  const auto cases = latching_cases();
  for (std::size_t number = 1; number < cases.size(); ++number) {
    const auto cause = static_cast<Cause>(number);
    CAPTURE(number);
    const bool no_fault = std::find(kNoFaults.begin(), kNoFaults.end(), cause) != kNoFaults.end();
    REQUIRE(cases[number].has_value() == !no_fault);
    if (no_fault) continue;
    Bench bench;
    bench.press();
    REQUIRE(bench.state() == LoopState::kEngaged);
    REQUIRE(bench.force() > kFelt);
    for (int k = 0; k < 1000 && bench.state() != LoopState::kFault; ++k) {
      cases[number]->inject(bench);
    }
    REQUIRE(bench.state() == LoopState::kFault);
    CHECK(bench.cause() == cause);
    CHECK(bench.force() == 0.0);
    cases[number]->end(bench);
    // It stays until somebody says so.
    bench.run(200);
    CHECK(bench.state() == LoopState::kFault);
    CHECK(bench.force() == 0.0);
    bench.send(ClearCommand{});
    bench.press();
    CHECK(bench.state() == LoopState::kEngaged);
    CHECK(bench.force() > kFelt);
  }
}

TEST_CASE("a simulation whose numbers are lost is a fault, and begins anew with a Clear") {
  Bench bench;
  bench.press();
  REQUIRE(bench.force() > kFelt);
  bench.poison();
  bench.run(10);
  CHECK(bench.state() == LoopState::kFault);
  CHECK(bench.cause() == Cause::kNotFinite);
  CHECK(bench.force() == 0.0);
  bench.send(ClearCommand{});
  bench.press();
  CHECK(bench.state() == LoopState::kEngaged);
  CHECK(bench.force() > kFelt);
}

TEST_CASE(
    "a clutch that has brought the tool out of reach of every pose is forgotten with a Clear") {
  const std::string scaled_wall = [] {
    std::string text = kWallScene;
    text.insert(text.find("pose_wg"), "workspace { scale: 100 }\n  ");
    return text;
  }();
  LoopRun run(scaled_wall);
  run.tick(Vector3(9e4, 0.0, 0.0));
  run.send(ClutchCommand{0, true});
  run.tick(Vector3(9e4, 0.0, 0.0));
  run.tick(Vector3(-9e4, 0.0, 0.0));
  run.send(ClutchCommand{0, false});
  run.tick(Vector3(-9e4, 0.0, 0.0));
  const Vector3 home(0.0, 0.0, kHome / 100.0);
  for (int k = 0; k < 100; ++k) run.tick(home);
  REQUIRE(run.tick(home).tick.state == LoopState::kFault);
  run.send(ClearCommand{});
  for (int k = 0; k < 300; ++k) run.tick(home);
  CHECK(run.tick(home).tick.state == LoopState::kEngaged);
  const Vector3 pressed(0.0, 0.0, (kTouch - kDepth) / 100.0);
  for (int k = 0; k < 50; ++k) run.tick(pressed);
  CHECK(force(run.tick(pressed)).z() > kFelt);
}

TEST_CASE(
    "poses beyond what the world holds are a fault that Clear mends once they are near again") {
  const std::string scaled_wall = [] {
    std::string text = kWallScene;
    text.insert(text.find("pose_wg"), "workspace { scale: 100 }\n  ");
    return text;
  }();
  LoopRun run(scaled_wall);
  const auto far_away = [&] { return run.tick(Vector3(2e5, 0.0, 0.0)); };
  for (int k = 0; k < 10; ++k) far_away();
  CHECK(far_away().tick.state == LoopState::kFault);
  CHECK(run.tick().tick.cause == Cause::kNotFinite);
  auto change = std::make_unique<SettingsChange>();
  change->to = run.loop().scene().settings;
  change->from = change->to;
  change->to.tools[0].scale = 1.0;
  run.change(std::move(change));
  const Vector3 home(0.0, 0.0, kHome);
  for (int k = 0; k < 100; ++k) run.tick(home);
  CHECK(run.tick(home).tick.state == LoopState::kFault);
  run.send(ClearCommand{});
  for (int k = 0; k < 300; ++k) run.tick(home);
  CHECK(run.tick(home).tick.state == LoopState::kEngaged);
  const Vector3 pressed(0.0, 0.0, kTouch - kDepth);
  for (int k = 0; k < 50; ++k) run.tick(pressed);
  CHECK(force(run.tick(pressed)).z() > kFelt);
}

}  // namespace hapticd::test
