// The driver against the reference firmware, tick by tick in the test's own time. Truth: what the
// firmware was told and gives, and the rules for hosts of PROFILE.md.
#include "device/hid/hid_device.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/device/hid/hid_loop.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE(
    "force is asked for as the profile says: an echo first, then ENABLE and zeros, then force") {
  Loop loop;
  loop.ticks(20, 0.5, true);
  const auto commands = loop.plugged.commands();
  const auto enabling =
      std::find_if(commands.begin(), commands.end(), [](const auto& c) { return c.flags != 0; });
  REQUIRE(enabling != commands.end());
  CHECK(enabling != commands.begin());
  CHECK(enabling->force_un == std::array<std::int32_t, 3>{});
  const auto pushing = std::find_if(commands.begin(), commands.end(),
                                    [](const auto& c) { return c.force_un[1] != 0; });
  REQUIRE(pushing != commands.end());
  CHECK(pushing > enabling);
  CHECK(pushing->force_un[1] == 500'000);
  CHECK(loop.ticks(1, 0.5, true).force_un[1] == 500'000);
  CHECK((loop.sample.flags & kDeviceEnabled) != 0);
}

TEST_CASE("no command has a force unless the newest state the loop has read says ENABLED") {
  SplitMix64 random(3);
  Loop loop;
  bool enable = false;
  double force = 0.0;
  for (std::int64_t k = scaled(20'000); k > 0; --k) {
    if (random.chance(0.05)) enable = random.chance(0.7);
    if (random.chance(0.1)) force = random.uniform(-3.0, 3.0);
    if (random.chance(0.01)) loop.plugged.bench.sensors.emergency_stop = random.chance(0.3);
    if (random.chance(0.005)) loop.plugged.frame(30'000);
    if (random.chance(0.01)) loop.device->write_zero(clock_ns + kReadLate_ns);
    loop.tick(force, enable);
    const hid::CommandReport sent = loop.plugged.commands().back();
    const bool enabled = (loop.sample.flags & kDeviceEnabled) != 0;
    if (!enabled || !enable) REQUIRE(sent.force_un == std::array<std::int32_t, 3>{});
    loop.commands = loop.plugged.commands().size();
  }
}

TEST_CASE("a device that takes ENABLE back gets none until the loop has let go") {
  Loop loop;
  loop.ticks(20, 0.5, true);
  loop.plugged.bench.sensors.emergency_stop = true;
  loop.ticks(3, 0.5, true);
  CHECK((loop.sample.flags & kDeviceEmergencyStop) != 0);
  loop.plugged.bench.sensors.emergency_stop = false;
  const std::size_t before = loop.plugged.commands().size();
  loop.ticks(20, 0.5, true);
  const auto commands = loop.plugged.commands();
  for (std::size_t k = before; k < commands.size(); ++k) CHECK(commands[k].flags == 0);
  loop.ticks(3, 0.0, false);
  CHECK(loop.ticks(20, 0.5, true).force_un[1] == 500'000);
}

TEST_CASE(
    "a latched watchdog is cleared when the loop asks for it, even with a command long expired") {
  Loop loop;
  loop.ticks(20, 0.5, true);
  loop.plugged.frame(30'000);
  clock_ns += 30 * kTick_ns;
  loop.ticks(3, 0.0, false);
  CHECK((loop.sample.flags & kDeviceWatchdogFired) != 0);
  DeviceCommand command;
  command.clear_faults = true;
  command.expires_ns = 0;
  loop.device->write(clock_ns + kReadLate_ns, command);
  loop.plugged.wait_for(++loop.commands);
  loop.ticks(2, 0.0, false);
  CHECK((loop.sample.flags & kDeviceWatchdogFired) == 0);
  CHECK(loop.ticks(20, 0.5, true).force_un[1] == 500'000);
}

TEST_CASE("the guardian's zero takes the force from a device whose loop stands still") {
  Loop loop;
  loop.ticks(20, 0.5, true);
  const std::size_t before = loop.plugged.commands().size();
  loop.device->write_zero(clock_ns + kReadLate_ns);
  loop.plugged.wait_for(before + 1);
  CHECK(loop.plugged.frame().motors_on == false);
}

TEST_CASE("a queue that overflowed is thrown away whole, and the next report is used") {
  Loop loop;
  loop.ticks(10);
  for (int k = 0; k < 100; ++k) loop.plugged.frame();
  clock_ns += 100 * kTick_ns;
  loop.step(0.0, false);
  CHECK(loop.outcome == ReadOutcome::kNothing);
  CHECK(loop.device->counters().overflows == 1);
  loop.ticks(1);
  CHECK(loop.outcome == ReadOutcome::kFresh);
  CHECK(clock_ns - loop.sample.t_ns <= kTick_ns);
}

TEST_CASE("of several reports the newest counts, and the others are not called lost") {
  Loop loop;
  loop.ticks(10);
  const std::uint64_t counter = loop.sample.counter;
  for (int k = 0; k < 7; ++k) loop.plugged.frame(125);
  loop.plugged.frame(125);
  clock_ns += kTick_ns;
  loop.step(0.0, false);
  CHECK(loop.sample.counter == counter + 8);
  CHECK(loop.device->counters().superseded == 7);
  CHECK(loop.device->counters().lost == 0);
}

TEST_CASE("bytes that are no report are counted and nothing else") {
  Loop loop;
  loop.ticks(10);
  const DeviceSample before = loop.sample;
  loop.plugged.inject({1, 2, 3});
  loop.plugged.inject(std::vector<std::uint8_t>(64, 0xFF));
  loop.step(0.0, false);
  CHECK(loop.outcome == ReadOutcome::kNothing);
  CHECK(loop.sample.counter == before.counter);
  CHECK(loop.device->counters().malformed == 2);
}

TEST_CASE(
    "unplugged it is lost; plugged in again it goes on with a later sample and without force") {
  Loop loop;
  loop.ticks(20, 0.5, true);
  const std::uint64_t counter = loop.sample.counter;
  loop.plugged.set_plugged(false);
  loop.tick(0.5, true);
  CHECK(loop.outcome == ReadOutcome::kLost);
  CHECK(loop.device->failed());
  loop.device->detach();
  loop.plugged.set_plugged(true);
  loop.device->attach(loop.plugged.channel());
  loop.commands = loop.plugged.commands().size();
  CHECK(loop.ticks(1, 0.5, true).motors_on == false);
  CHECK(loop.outcome == ReadOutcome::kFresh);
  CHECK(loop.sample.counter > counter);
  const hid::CommandReport first = loop.plugged.commands()[loop.commands - 1];
  CHECK(first.flags == 0);
}

TEST_CASE("the delay that is measured is that from a sample to the taking of its command") {
  for (const std::uint32_t late_us : {0U, 300U, 990U, 2500U}) {
    CAPTURE(late_us);
    Loop loop;
    loop.late_us = late_us;
    loop.ticks(400);
    CHECK(std::abs(loop.sample.measured_delay_s - 1e-6 * late_us) <= 10.001e-6);
  }
}

TEST_CASE("a device with axes of its own is read and pushed along those of D") {
  // Raw x right, y toward the user, z up: left-handed.
  AxisMapping axes;
  axes.raw_axis = {0, 2, 1};
  axes.force_sign = {1.0, -1.0, 1.0};
  Loop loop(kHapHasVelocity, axes);
  loop.plugged.bench.sensors.pos_nm[1] = 3'000'000;
  loop.plugged.bench.sensors.pos_nm[2] = -20'000'000;
  loop.plugged.bench.sensors.avel[2] = 500;
  const HapOutput output = loop.ticks(20, 0.5, true);
  CHECK(loop.sample.p_DH[1] == doctest::Approx(-0.020));
  CHECK(loop.sample.p_DH[2] == doctest::Approx(0.003));
  CHECK(loop.sample.w_DH_D == Array3{-0.0, -0.5, -0.0});
  CHECK(output.force_un[1] == 0);
  CHECK(output.force_un[2] == -500'000);
}

TEST_CASE("of a faster device samples are used for two of its frames and the time to read them") {
  static_assert(hid::oldest_sample_ns(1000) == 2'500'000);
  static_assert(hid::oldest_sample_ns(8000) == 750'000);
  static_assert(hid::oldest_sample_ns(100) == 2'500'000);
  for (const std::int64_t later_ns : {-1'000, 1'000}) {
    CAPTURE(later_ns);
    Loop loop(kHapHasVelocity, {}, 8000);
    loop.ticks(50);
    loop.plugged.frame();
    clock_ns += kTick_ns + 750'000 + later_ns;
    loop.step(0.0, false);
    CHECK(loop.outcome == (later_ns < 0 ? ReadOutcome::kFresh : ReadOutcome::kNothing));
    CHECK(loop.device->counters().too_old == (later_ns < 0 ? 0 : 1));
  }
}

TEST_CASE("a wait ends with a report that comes while it lasts, not with one that was there") {
  Loop loop;
  loop.ticks(10);
  const PaceSource pace = loop.device->pace();
  CHECK(pace.frame_ns == kTick_ns);
  const auto wait = [&] { return pace.wait(pace.device, clock_ns + kTick_ns); };
  const auto counter = loop.sample.counter;
  CHECK(wait() == Waited::kTime);
  loop.plugged.frame(500);
  CHECK(wait() == Waited::kMissed);
  loop.plugged.meanwhile = [&] { loop.plugged.frame(500); };
  CHECK(wait() == Waited::kReport);
  clock_ns += kTick_ns;
  loop.step(0.0, false);
  CHECK(loop.outcome == ReadOutcome::kFresh);
  CHECK(loop.sample.counter == counter + 2);
  CHECK(loop.device->counters().superseded == 1);
  CHECK(loop.device->counters().lost == 0);
}

TEST_CASE("what was put aside by a wait is read, and thrown away with a queue that overflowed") {
  Loop loop;
  loop.ticks(10);
  const PaceSource pace = loop.device->pace();
  const auto counter = loop.sample.counter;
  loop.plugged.frame(1000);
  clock_ns += kTick_ns;
  CHECK(pace.wait(pace.device, clock_ns) == Waited::kMissed);
  loop.step(0.0, false);
  CHECK(loop.sample.counter == counter + 1);
  for (int k = 0; k < 100; ++k) loop.plugged.frame();
  clock_ns += 100 * kTick_ns;
  CHECK(pace.wait(pace.device, clock_ns) == Waited::kTime);
  loop.step(0.0, false);
  CHECK(loop.outcome == ReadOutcome::kNothing);
  CHECK(loop.device->counters().overflows == 1);
}

TEST_CASE(
    "there is no waiting for a device that is unplugged, detached or attached anew in between") {
  Loop loop;
  loop.ticks(10);
  const PaceSource pace = loop.device->pace();
  loop.plugged.frame();
  CHECK(pace.wait(pace.device, clock_ns) == Waited::kMissed);
  loop.plugged.set_plugged(false);
  CHECK(pace.wait(pace.device, clock_ns) == Waited::kGone);
  loop.device->detach();
  CHECK(pace.wait(pace.device, clock_ns) == Waited::kGone);
  loop.plugged.set_plugged(true);
  loop.device->attach(loop.plugged.channel());
  // The report that was put aside was of the time before.
  CHECK(pace.wait(pace.device, clock_ns) == Waited::kTime);
}

TEST_CASE("a sample that is old when it is read is not used") {
  Loop loop;
  loop.ticks(50);
  loop.plugged.frame();
  clock_ns += 10 * kTick_ns;
  loop.step(0.0, false);
  CHECK(loop.outcome == ReadOutcome::kNothing);
  CHECK(loop.device->counters().too_old == 1);
}

}  // namespace hapticd::test
