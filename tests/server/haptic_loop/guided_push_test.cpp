// The push of the guided check: how the force of a tool runs while it is pushed, and what ends it.
// Truth: the trapezoid in closed form, from the times in its definition.
#include "server/haptic_loop/guided_push.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tests/server/haptic_loop/loop_run.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

/// A device that can push a person and is held still wherever the test wants.
class HeldDevice final : public HapticDevice {
 public:
  explicit HeldDevice(const DeviceProfile& profile) : profile_(profile) {
    sample_.flags = kDeviceAttached | kDeviceCalibrated;
  }
  [[nodiscard]] const DeviceProfile& profile() const noexcept override { return profile_; }
  HD_REALTIME ReadOutcome read(std::int64_t now_ns, DeviceSample& sample) noexcept override {
    ++sample_.counter;
    sample_.t_ns = now_ns;
    sample_.p_DH = to_array(p_DH);
    // A sensor that repeats itself to the bit is stuck.
    sample_.p_DH[0] += sample_.counter % 2 == 0 ? 1e-12 : 0.0;
    sample = sample_;
    if (dead_man_open) sample.flags |= kDeviceDeadManOpen;
    if (emergency_stop) sample.flags |= kDeviceEmergencyStop;
    return ReadOutcome::kFresh;
  }
  HD_REALTIME bool write(std::int64_t /*now_ns*/, const DeviceCommand& command) noexcept override {
    written = command;
    return true;
  }
  HD_REALTIME void write_zero(std::int64_t /*now_ns*/) noexcept override {}

  Vector3 p_DH{0.0, 0.0, 0.025};
  bool dead_man_open = false;
  bool emergency_stop = false;
  DeviceCommand written;

 private:
  DeviceProfile profile_;
  DeviceSample sample_;
};

/// A loop with such a device before the wall, engaged.
class CheckRun {
 public:
  CheckRun() {
    std::unique_ptr<PlayedScene> played = played_scene(kWallScene, 1);
    PlayedDevice& place = played->tools[0].device;
    auto device = std::make_unique<HeldDevice>(place.device->profile());
    held = device.get();
    place.facets = {};
    place.traits = {.can_push_a_person = true};
    place.device = device.get();
    place.owned = std::move(device);
    // Nothing that a port gives comes back by itself, as with a device of the HID profile.
    played->tools[0].limits.passivity.damping = 0.0;
    LoopOptions options;
    options.virtual_time = true;
    loop_ = std::make_unique<HapticLoop>(options, std::move(played), *channels_);
    engage();
  }
  void engage() {
    run(5);
    send(EngageCommand{});
    run(250);
    REQUIRE(state() == LoopState::kEngaged);
  }
  Vector3 tick() {
    loop_->tick_once(0);
    LoopEvent event;
    while (channels_->events.pop(event)) {
      if (std::holds_alternative<CommandRefused>(event.what)) ++refused;
    }
    while (channels_->ticks.pop(*told_)) {
    }
    return to_vector(held->written.f_H_D);
  }
  void run(int ticks) {
    for (int k = 0; k < ticks; ++k) tick();
  }
  void send(const LoopCommandBody& what) { REQUIRE(channels_->commands.push({++commands_, what})); }
  [[nodiscard]] LoopState state() const { return told_->state; }

  HeldDevice* held = nullptr;
  int refused = 0;

 private:
  std::unique_ptr<LoopChannels> channels_ = std::make_unique<LoopChannels>();
  std::unique_ptr<HapticLoop> loop_;
  std::unique_ptr<Tick> told_ = std::make_unique<Tick>();
  std::uint64_t commands_ = 0;
};

/// 0.3 N: 200 ms up, 600 ms, 200 ms down.
double trapezoid(double t_s) {
  if (t_s < 0.2) return 0.3 * t_s / 0.2;
  if (t_s < 0.8) return 0.3;
  return t_s < 1.0 ? 0.3 * (1.0 - t_s) / 0.2 : 0.0;
}

/// Force along z of a finger 2 mm in the wall at 1000 N/m.
constexpr double kPressed = 2.0;

}  // namespace

TEST_CASE("a push is a trapezoid of 0.3 N along its axis and nothing else, for all six") {
  CheckRun run;
  for (PushAxis axis = 1; axis <= 6; ++axis) {
    CAPTURE(axis);
    run.send(PushCommand{0, axis});
    const int along = (axis - 1) / 2;
    const double sign = axis % 2 == 1 ? 1.0 : -1.0;
    for (int k = 0; k < 1300; ++k) {
      Vector3 f_H_D = run.tick();
      CHECK(sign * f_H_D[along] == within(trapezoid(1e-3 * k), 1e-9));
      CHECK(f_H_D.norm() <= 0.3);
      f_H_D[along] = 0.0;
      CHECK(f_H_D.isZero(0.0));
      CHECK(to_vector(run.held->written.t_H_D).isZero(0.0));
    }
  }
}

TEST_CASE("while it is pushed a tool feels nothing else; its contact comes back by a ramp") {
  CheckRun run;
  // Not faster than a hand.
  for (int k = 0; k <= 100; ++k) {
    run.held->p_DH = {0.0, 0.0, 0.025 - 0.022 * k / 100.0};
    run.tick();
  }
  run.run(50);
  REQUIRE(run.tick().z() == within(kPressed, 1e-4));
  run.send(PushCommand{0, 2});
  for (int k = 0; k < 1300; ++k) {
    CAPTURE(k);
    const Vector3 f_H_D = run.tick();
    const double t_s = 1e-3 * k;
    const double share = std::clamp((t_s - 1.0) / 0.2, 0.0, 1.0);
    CHECK(std::abs(f_H_D.x() + trapezoid(t_s)) < 1e-6);
    CHECK(std::abs(f_H_D.z() - kPressed * share) < 1e-4);
  }
}

TEST_CASE("Stop and the emergency stop end a push in the tick that hears of them, for good") {
  for (const bool button : {false, true}) {
    CheckRun run;
    run.send(PushCommand{0, 3});
    run.run(400);
    REQUIRE(run.tick().y() == doctest::Approx(0.3));
    run.held->emergency_stop = button;
    if (!button) run.send(StopCommand{});
    CHECK(run.tick().isZero(0.0));
    CHECK(run.state() == LoopState::kFault);
    run.held->emergency_stop = false;
    run.run(5);
    run.send(ClearCommand{});
    run.engage();
    for (int k = 0; k < 1300; ++k) CHECK(run.tick().isZero(0.0));
  }
}

TEST_CASE("Disengage and a dead-man switch let go fade a push within 50 ms, for good") {
  for (const bool dead_man : {false, true}) {
    CheckRun run;
    run.send(PushCommand{0, 6});
    run.run(150);
    double last = -run.tick().z();
    REQUIRE(last > 0.2);
    run.held->dead_man_open = dead_man;
    if (!dead_man) run.send(DisengageCommand{});
    for (int k = 0; k < 52; ++k) {
      const double now = -run.tick().z();
      CHECK(now < (last > 0.0 ? last : 1e-300));
      last = now;
    }
    CHECK(last == 0.0);
    run.held->dead_man_open = false;
    run.engage();
    for (int k = 0; k < 1300; ++k) CHECK(run.tick().isZero(0.0));
  }
}

TEST_CASE("a push is refused where there is no force, and none follows later") {
  CheckRun run;
  run.send(DisengageCommand{});
  run.run(60);
  REQUIRE(run.state() == LoopState::kReady);
  run.send(PushCommand{0, 1});
  run.run(3);
  CHECK(run.refused == 1);
  run.engage();
  for (int k = 0; k < 1300; ++k) CHECK(run.tick().isZero(0.0));
}

TEST_CASE("a hand that gives way 6 mm to each push feels all of them") {
  CheckRun run;
  const Vector3 home = run.held->p_DH;
  // 1.8 mJ each, of 4 mJ that a port may give in all.
  for (int push = 0; push < 10; ++push) {
    run.send(PushCommand{0, 3});
    double most = 0.0;
    for (int k = 0; k < 1300; ++k) {
      run.held->p_DH = home + Vector3(0.0, 0.006 * std::clamp(k / 1000.0, 0.0, 1.0), 0.0);
      most = std::max(most, run.tick().y());
    }
    CHECK(most == doctest::Approx(0.3));
    for (int k = 0; k <= 100; ++k) {
      run.held->p_DH = home + Vector3(0.0, 0.006 * (100 - k) / 100.0, 0.0);
      run.tick();
    }
  }
}

TEST_CASE("a handle that is let go is given 4 mJ by a push, no more") {
  CheckRun run;
  const Vector3 home = run.held->p_DH;
  run.send(PushCommand{0, 3});
  double given = 0.0;
  double y = 0.0;
  for (int k = 0; k < 1000; ++k) {
    run.held->p_DH = home + Vector3(0.0, y, 0.0);
    const double f = run.tick().y();
    // It runs away with 100 mm/s.
    y += 1e-4;
    given += f * 1e-4;
  }
  CHECK(given > 1e-3);
  CHECK(given <= 4e-3);
}

TEST_CASE("a pause of the loop makes no jump of a push") {
  GuidedPush push;
  CHECK(follow_push(1, LoopState::kEngaged, 0.001, push));
  CHECK(push.t_s == 0.0);
  CHECK_FALSE(follow_push(0, LoopState::kEngaged, 0.7, push));
  // 5 ms of the ramp of 200 ms.
  CHECK(with_push(push, {}).f.x() == doctest::Approx(0.3 * 0.005 / 0.2));
}

}  // namespace hapticd::test
