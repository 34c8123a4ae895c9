// What a device says of its motors and switches is obeyed. Truth: the State report of
// force_device.h, by hand: bit 0 paused, 1 motors on, 2 safety switch, 3 override switch, 4 power.
#include <doctest/doctest.h>

#include <algorithm>

#include "device/pid/pid_device.h"
#include "tests/device/pid/force_device.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr unsigned kAllWell = 0x1E;

std::int64_t zero_clock() noexcept { return 0; }

struct Stick {
  explicit Stick(bool has_switches = true) : device(profile(), settings(has_switches), zero_clock) {
    device.attach(hardware.channel(), {3, 4});
    at_rest();
  }
  static DeviceProfile profile() {
    DeviceProfile made;
    made.driver = DeviceDriver::kPid;
    made.peak_force = 1.0;
    return made;
  }
  static pid::PidSettings settings(bool has_switches) {
    pid::PidSettings made;
    made.axes.force_scale = {1e-3, 1e-3, 1e-3};
    made.layout = pid::find_layout(DescriptorParts().joined()).layout;
    made.has_switches = has_switches;
    return made;
  }
  /// A report of the handle in the middle.
  void at_rest() {
    Bytes report(25, 0);
    report[0] = 1;
    hardware.push(report);
    read();
  }
  ReadOutcome read() { return device.read(now_ns += kMs, sample); }
  void say(unsigned flags) {
    hardware.push({2, static_cast<std::uint8_t>(flags), 0x01});
    read();
  }
  /// Half a newton along x, and what of it went to the device.
  int push() {
    DeviceCommand command{.enable = true};
    command.f_H_D = {0.5, 0.0, 0.0};
    command.expires_ns = now_ns + 5 * kMs;
    REQUIRE(device.write(now_ns, command));
    // The mark that follows says that it has gone out.
    device.detach();
    const auto sent = hardware.sent();
    int size = 0;
    for (const Bytes& report : sent) {
      if (report[0] == 5 && report[1] == 3) size = std::max(size, report[2] | report[3] << 8);
    }
    return size;
  }

  ForceDevice hardware;
  pid::PidDevice device;
  DeviceSample sample;
  std::int64_t now_ns = 0;
};

bool lets_go(unsigned flags) { return (flags & 1U) != 0 || (flags & kAllWell) != kAllWell; }

}  // namespace

TEST_CASE("a stick that has said nothing, or that all is well, is told to push") {
  Stick silent;
  CHECK((silent.sample.flags & kDeviceDeadManOpen) == 0);
  DeviceCommand command{.enable = true};
  command.f_H_D = {0.5, 0.0, 0.0};
  silent.device.write(silent.now_ns, command);
  silent.hardware.wait_until_sent({{5, 3, 0xF4, 0x01}, {5, 4, 0, 0}});
  silent.say(kAllWell);
  CHECK((silent.sample.flags & kDeviceDeadManOpen) == 0);
  silent.at_rest();
  CHECK((silent.sample.flags & kDeviceEnabled) != 0);
}

TEST_CASE("whatever a stick says, it is pushed only where nothing of it says no") {
  SplitMix64 random(fresh_seed());
  for (std::int64_t k = 0; k < scaled(300); ++k) {
    Stick stick;
    unsigned said = kAllWell;
    for (std::uint64_t times = 1 + random.below(4); times > 0; --times) {
      said = static_cast<unsigned>(random.chance(0.4) ? kAllWell : random.below(32));
      stick.say(said);
    }
    CHECK(((stick.sample.flags & kDeviceDeadManOpen) != 0) == lets_go(said));
    if (lets_go(said)) CHECK(stick.push() == 0);
  }
}

TEST_CASE("a force that is on is taken back by the next command after the switch goes off") {
  Stick stick;
  stick.say(kAllWell);
  DeviceCommand command{.enable = true};
  command.f_H_D = {0.5, 0.0, 0.25};
  stick.device.write(stick.now_ns, command);
  stick.hardware.wait_until_sent({{5, 3, 0xF4, 0x01}, {5, 4, 0, 0}});
  stick.say(kAllWell & ~4U);
  CHECK((stick.sample.flags & kDeviceDeadManOpen) != 0);
  CHECK((stick.sample.flags & kDeviceEnabled) == 0);
  stick.device.write(stick.now_ns, command);
  stick.hardware.wait_until_sent({{5, 3, 0, 0}, {5, 4, 0, 0}});
}

TEST_CASE(
    "switches that a maker declares and never sets are looked past where the profile says so") {
  Stick stick(false);
  // As OpenFFBoard: motors on and power, no switch.
  stick.say(0x12);
  CHECK((stick.sample.flags & kDeviceDeadManOpen) == 0);
  stick.say(0x10);
  CHECK((stick.sample.flags & kDeviceDeadManOpen) != 0);
  stick.say(0x13);
  CHECK((stick.sample.flags & kDeviceDeadManOpen) != 0);
}

TEST_CASE(
    "a stick that lies still and says that it lets go is heard without a report of its place") {
  Stick stick;
  const std::uint64_t counter = stick.sample.counter;
  stick.say(0);
  CHECK(stick.sample.counter == counter + 1);
  CHECK(stick.sample.v_DH_D == Array3{});
  // Said again it is nothing new.
  stick.hardware.push({2, 0, 0x01});
  CHECK(stick.read() == ReadOutcome::kNothing);
  // A short report says nothing.
  stick.hardware.push({2, 0x1E});
  CHECK(stick.read() == ReadOutcome::kNothing);
  CHECK(stick.device.counters().states == 2);
}

TEST_CASE("what another attachment has said is forgotten") {
  Stick stick;
  stick.say(0);
  ForceDevice again;
  stick.device.attach(again.channel(), {3, 4});
  Bytes report(25, 0);
  report[0] = 1;
  again.push(report);
  REQUIRE(stick.read() == ReadOutcome::kFresh);
  CHECK((stick.sample.flags & kDeviceDeadManOpen) == 0);
  stick.device.detach();
}

}  // namespace hapticd::test
