// The stiffness clamp reckons with the delay a device was measured to have. Truth: the delay its
// plant was made with, and the clamp's closed form, half of (b + B) / (T/2 + t_d).
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "device/simulated/simulated_device.h"
#include "server/haptic_loop/device_limits.h"
#include "server/haptic_loop/tool_loop.h"
#include "tests/server/haptic_loop/loop_run.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

const LoopSetting kHand{"simulated", "premium_3_0_6dof", false, true};

/// The profile's device, but with a longer delay than it declares.
DeviceProfile slower(const PlayedScene& scene, double delay_s) {
  DeviceProfile profile = scene.tools[0].device.device->profile();
  profile.delay = delay_s;
  return profile;
}

TEST_CASE("a longer delay than declared is found out, and the stiffness falls to what it bears") {
  auto channels = std::make_unique<LoopChannels>();
  std::unique_ptr<PlayedScene> played = played_scene(kWallScene, 1, kHand);
  const double declared = played->tools[0].stiffness_limits.delay_s;
  const DeviceProfile profile = slower(*played, 3e-3);
  auto device = std::make_unique<SimulatedDevice>(profile, SimulatedOptions{});
  PlayedDevice& place = played->tools[0].device;
  place.device = device.get();
  place.facets = {.hand = device.get()};
  place.owned = std::move(device);
  const double damping = profile.damping + played->settings.tools[0].coupling_damping;
  const double scale = played->tools[0].grant.scale;
  HapticLoop loop({}, std::move(played), *channels);
  const auto told = std::make_unique<Tick>();
  ToolTick tool;
  for (int tick = 0; tick < 600; ++tick) {
    loop.tick_once(1'000'000'000 + tick * 1'000'000);
    while (channels->ticks.pop(*told)) tool = told->tools[0];
    if (tick < 200) CHECK(tool.stiffness.delay == declared);
  }
  // Both acts of the plant are rounded to its sub-steps.
  CHECK(std::abs(tool.stiffness.delay - profile.delay) <=
        2e-9 * static_cast<double>(kPlantStep_ns));
  CHECK(tool.sample.measured_delay_s == tool.stiffness.delay);
  const double bound =
      std::min(0.5 * damping / (0.5e-3 + tool.stiffness.delay), profile.stiffness_max);
  CHECK(tool.stiffness.bound == within(bound, 1e-12));
  CHECK(tool.stiffness.scale < scale);
}

TEST_CASE("a device that echoes nothing keeps the delay that was declared") {
  LoopRun run(kWallScene, {"scripted", "premium_3_0_6dof", false, true});
  const double declared = run.loop().scene().tools[0].device.device->profile().delay;
  for (int tick = 0; tick < 600; ++tick) run.tick({0.0, 0.0, 0.025});
  const ToolTick& tool = run.tick().tick.tools[0];
  CHECK(tool.stiffness.delay == declared);
  CHECK(std::isnan(tool.sample.measured_delay_s));
}

TEST_CASE("a delay that makes no sense changes nothing") {
  LoopRun run(kWallScene, kHand);
  PlayedTool& tool = run.loop().scene().tools[0];
  const double before = tool.stiffness_limits.delay_s;
  DeviceSample sample;
  for (const double delay : {std::nan(""), -1e-3, 1.5, HUGE_VAL, -HUGE_VAL, before}) {
    CAPTURE(delay);
    sample.measured_delay_s = delay;
    CHECK_FALSE(learn_delay(sample, tool));
    CHECK(tool.stiffness_limits.delay_s == before);
  }
  sample.measured_delay_s = 0.02;
  CHECK(learn_delay(sample, tool));
  CHECK(tool.stiffness_limits.delay_s == 0.02);
}

TEST_CASE("a wrench counts as three ticks late until it is known how late it is") {
  constexpr double kPeriod_s = 1e-3;
  DeviceProfile profile;
  const DriverTraits motors;
  DriverTraits simulated;
  simulated.can_push_a_person = false;
  StiffnessLimits limits = stiffness_limits_of(profile, motors, kPeriod_s);
  CHECK(flight_of(limits) == 3);
  for (const auto& [delay_s, ticks] : {std::pair{1e-4, 1}, {1e-3, 1}, {2e-3, 2}, {2.5e-3, 3}}) {
    limits.delay_s = delay_s;  // as measured
    CHECK(flight_of(limits) == ticks);
    profile.delay = delay_s;
    CHECK(flight_of(stiffness_limits_of(profile, motors, kPeriod_s)) == ticks);
  }
  profile.delay = 0.01;
  CHECK(flight_of(stiffness_limits_of(profile, motors, kPeriod_s)) == 3);
  profile.delay = 0.0;
  CHECK(flight_of(stiffness_limits_of(profile, simulated, kPeriod_s)) == 0);
  // Whose damping is a guess may be as late as it likes, whatever it states.
  profile.damping_guessed = true;
  profile.delay = 1e-3;
  CHECK(flight_of(stiffness_limits_of(profile, motors, kPeriod_s)) == 3);
  CHECK(port_damping_of(profile, motors).translational == 0.0);
  CHECK(port_damping_of(profile, simulated).translational == profile.damping);
}

}  // namespace
}  // namespace hapticd::test
