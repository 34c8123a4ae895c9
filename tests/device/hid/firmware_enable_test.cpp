// Enabling, watchdog, latches and refusals of the reference firmware, by the words of PROFILE.md,
// sections 4, 7 and 8.
#include <doctest/doctest.h>

#include <array>
#include <cstring>
#include <vector>

#include "tests/device/hid/firmware_bench.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

using hid::kCommandClearFault;
using hid::kCommandEnable;

constexpr std::int32_t kOneNewton_un = 1'000'000;
constexpr std::uint32_t kMs = 1000;

TEST_CASE("a device begins disabled, and a command with force does not change that") {
  Bench bench;
  CHECK(bench.sound);
  CHECK(is_zero(bench.servo()));
  CHECK(bench.state().status == hid::kStatusCalibrated);
  CHECK(is_zero(bench.push(kOneNewton_un)));
}

TEST_CASE("a zero command with ENABLE enables, and then force flows") {
  Bench bench;
  REQUIRE(bench.enable());
  CHECK(bench.shows(hid::kStatusEnabled));
  CHECK_FALSE(bench.shows(hid::kStatusActive));
  const HapOutput output = bench.push(kOneNewton_un);
  CHECK(output.motors_on);
  CHECK(output.force_un[0] == kOneNewton_un);
  CHECK(bench.shows(hid::kStatusActive));
}

TEST_CASE("ENABLE counts only when it goes from 0 to 1") {
  Bench bench;
  bench.servo();
  // Not zero: refused, and the ENABLE after it is none from 0 to 1.
  bench.push(kOneNewton_un);
  bench.send_flags(kCommandEnable);
  CHECK_FALSE(bench.servo().motors_on);
  bench.send_flags(0);
  bench.send_flags(kCommandEnable);
  CHECK(bench.servo().motors_on);
}

TEST_CASE("any part of a command that is not zero keeps it from enabling") {
  std::vector<hid::AffineReport> reports(9);
  reports[0].base.force_un[2] = 1;
  reports[1].base.torque_unm[1] = -1;
  reports[2].base.grip_mn = 1;
  reports[3].k_npm[0] = 1;
  reports[4].k_npm[5] = -1;
  reports[5].b_mnspm[2] = 1;
  reports[6].kr_mnmprad[1] = 1;
  reports[7].br_10unmsprad[0] = 1;
  for (std::size_t i = 0; i < reports.size(); ++i) {
    CAPTURE(i);
    Bench bench(hid::kCanAffine);
    bench.servo();
    reports[i].base.ref_seq = bench.state().seq;
    reports[i].base.flags = kCommandEnable;
    CHECK(bench.send(reports[i]));
    // The last one is all zero.
    CHECK(bench.servo().motors_on == (i == 8));
  }
}

TEST_CASE("a command without ENABLE ends the force at once") {
  Bench bench;
  REQUIRE(bench.enable());
  CHECK_FALSE(is_zero(bench.push(kOneNewton_un)));
  bench.send(hid::CommandReport{.force_un = {kOneNewton_un, 0, 0}});
  CHECK(is_zero(bench.servo()));
}

TEST_CASE("without a new command the force ends when the watchdog time is over, not before") {
  Bench bench;
  REQUIRE(bench.enable());
  bench.send(hid::CommandReport{.flags = kCommandEnable, .force_un = {kOneNewton_un, 0, 0}});
  CHECK(bench.servo(20 * kMs - 1).motors_on);
  CHECK(is_zero(bench.servo(1)));
  CHECK(bench.shows(hid::kStatusWatchdog));
}

TEST_CASE("a repeated seq does not feed the watchdog, is not obeyed and is no mistake") {
  Bench bench;
  REQUIRE(bench.enable());
  bench.send_flags(kCommandEnable);
  hid::CommandReport again{.flags = kCommandEnable, .seq = bench.seq, .force_un = {1, 0, 0}};
  for (int k = 0; k < 19; ++k) {
    CHECK(bench.receive(hid::encode(again)));
    const HapOutput output = bench.servo(kMs);
    CHECK(output.motors_on);
    CHECK(output.force_un[0] == 0);
  }
  CHECK(bench.receive(hid::encode(again)));
  CHECK(is_zero(bench.servo(kMs)));
  CHECK((bench.state().fault & hid::kFaultBadCommand) == 0);
}

TEST_CASE("a command that comes too late does not save the watchdog") {
  Bench bench;
  REQUIRE(bench.enable());
  bench.now_us += 21 * kMs;  // no servo cycle meanwhile
  bench.send_flags(kCommandEnable);
  CHECK(is_zero(bench.servo(0)));
  CHECK(bench.shows(hid::kStatusWatchdog));
}

TEST_CASE("WATCHDOG stays until CLEAR_FAULT, which enables nothing by itself") {
  Bench bench;
  REQUIRE(bench.enable());
  bench.servo(20 * kMs);
  CHECK_FALSE(bench.enable());
  hap_bus_reset(&bench.device);
  CHECK_FALSE(bench.enable());
  CHECK(bench.shows(hid::kStatusWatchdog));
  bench.send_flags(kCommandClearFault | kCommandEnable);
  CHECK(is_zero(bench.servo()));
  CHECK_FALSE(bench.shows(hid::kStatusWatchdog));
  // From CLEAR_FAULT to ENABLE is from 0 to 1.
  bench.send_flags(kCommandEnable);
  CHECK(bench.servo().motors_on);
}

TEST_CASE("CLEAR_FAULT disables a device that is enabled") {
  Bench bench;
  REQUIRE(bench.enable());
  bench.send_flags(kCommandClearFault | kCommandEnable);
  CHECK(is_zero(bench.servo()));
}

TEST_CASE("a watchdog of another time is that of Config, within what the device allows") {
  Bench bench;
  CHECK(bench.config().wd_ms == 20);
  hid::Config config = kConfig;
  for (const auto& [wanted, got] : {std::pair{5, 5}, {0, 2}, {1, 2}, {101, 100}, {65535, 100}}) {
    config.wd_ms = static_cast<std::uint16_t>(wanted);
    CHECK(bench.send(config));
    CHECK(bench.config().wd_ms == got);
  }
  config.wd_ms = 5;
  bench.send(config);
  REQUIRE(bench.enable());
  bench.send_flags(kCommandEnable);
  CHECK(bench.servo(5 * kMs - 1).motors_on);
  CHECK_FALSE(bench.servo(1).motors_on);
}

TEST_CASE("suspend, unplug and reset end the force and are latched as bus loss") {
  for (const bool reset : {false, true}) {
    Bench bench;
    REQUIRE(bench.enable());
    CHECK_FALSE(is_zero(bench.push(kOneNewton_un)));
    if (reset) {
      hap_bus_reset(&bench.device);
    } else {
      bench.sensors.bus_ready = false;
    }
    CHECK(is_zero(bench.servo()));
    bench.sensors.bus_ready = true;
    CHECK(is_zero(bench.push(kOneNewton_un)));
    CHECK_FALSE(bench.enable());
    const hid::StateReport state = bench.state();
    CHECK((state.status & hid::kStatusWatchdog) != 0);
    CHECK((state.status & hid::kStatusFault) != 0);
    CHECK(state.fault == hid::kFaultUsb);
    bench.send_flags(kCommandClearFault);
    CHECK(bench.enable());
  }
}

TEST_CASE("a bus lost while disabled latches nothing, and nothing enables without a bus") {
  Bench bench;
  bench.sensors.bus_ready = false;
  CHECK_FALSE(bench.enable());
  bench.sensors.bus_ready = true;
  bench.servo();
  hap_bus_reset(&bench.device);
  CHECK(bench.state().status == hid::kStatusCalibrated);
  CHECK(bench.enable());
}

TEST_CASE("a reset of the bus forgets Config and command") {
  Bench bench;
  bench.send(kConfig);
  bench.servo();
  bench.send_flags(0);
  CHECK(bench.state().cmd_seq == 1);
  hap_bus_reset(&bench.device);
  CHECK(bench.config() == hid::Config{20, 900, 300, kHapResetSpeedCap, 0});
  const hid::StateReport state = bench.state();
  CHECK(state.cmd_seq == 0);
  CHECK(state.cmd_age == hid::kOldestCommand);
  // The same seq is new in a new session.
  bench.seq = 0;
  CHECK(bench.enable());
}

TEST_CASE("a fault ends the force, is latched, and cleared only when its cause is gone") {
  for (unsigned bit = 0; bit < 8; ++bit) {
    CAPTURE(bit);
    const auto fault = static_cast<std::uint16_t>(1U << bit);
    Bench bench;
    REQUIRE(bench.enable());
    bench.sensors.faults = fault;
    CHECK(is_zero(bench.push(kOneNewton_un)));
    bench.send_flags(kCommandClearFault);
    CHECK_FALSE(bench.enable());
    bench.sensors.faults = 0;
    CHECK_FALSE(bench.enable());
    CHECK(bench.state().fault == fault);
    CHECK(bench.shows(hid::kStatusFault));
    bench.send_flags(kCommandClearFault);
    CHECK(bench.enable());
    CHECK(bench.state().fault == 0);
  }
}

TEST_CASE("the emergency stop ends the force, and letting it go does not bring it back") {
  Bench bench;
  REQUIRE(bench.enable());
  bench.sensors.emergency_stop = true;
  CHECK(is_zero(bench.push(kOneNewton_un)));
  CHECK(bench.shows(hid::kStatusEmergencyStop));
  CHECK_FALSE(bench.enable());
  bench.send_flags(kCommandEnable);
  bench.sensors.emergency_stop = false;
  CHECK(is_zero(bench.push(0)));
  CHECK(is_zero(bench.push(kOneNewton_un)));
  CHECK(bench.enable());
}

TEST_CASE("a dead-man switch has to be held, where there is one") {
  Bench bench(hid::kHasDeadMan);
  CHECK_FALSE(bench.enable());
  bench.sensors.dead_man_held = true;
  REQUIRE(bench.enable());
  CHECK(bench.shows(hid::kStatusDeadManHeld));
  bench.sensors.dead_man_held = false;
  CHECK(is_zero(bench.push(kOneNewton_un)));
  bench.sensors.dead_man_held = true;
  CHECK(is_zero(bench.push(0)));
  Bench without;
  without.sensors.dead_man_held = true;
  CHECK(without.enable());
  CHECK_FALSE(without.shows(hid::kStatusDeadManHeld));
}

TEST_CASE("under a hand limits only fall, whatever is asked for") {
  SplitMix64 random(fresh_seed());
  Bench bench(hid::kHasVelocity);
  REQUIRE(bench.enable());
  hid::Config before = bench.config();
  for (std::int64_t k = 0; k < scaled(10'000); ++k) {
    const auto any = [&] { return static_cast<std::uint16_t>(random.below(65'536)); };
    bench.send(hid::Config{any(), any(), any(), any(), 0});
    const hid::Config now = bench.config();
    CHECK(now.wd_ms <= before.wd_ms);
    CHECK(now.f_cap_cn <= before.f_cap_cn);
    CHECK(now.tau_cap_mnm <= before.tau_cap_mnm);
    CHECK(now.v_cap_mmps <= before.v_cap_mmps);
    before = now;
  }
  bench.send_flags(0);
  bench.servo();
  REQUIRE_FALSE(bench.device.enabled);
  bench.send(hid::Config{50, 500, 200, 4000, 0});
  CHECK(bench.config() == hid::Config{50, 500, 200, 4000, 0});
}

TEST_CASE("a handle that is thrown stops a device to which no host has told a speed") {
  Bench bench(hid::kHasVelocity);
  REQUIRE(bench.enable());
  bench.sensors.vel[0] = 29'000;
  CHECK_FALSE(is_zero(bench.push(kOneNewton_un)));
  bench.sensors.vel[0] = 31'000;
  CHECK(is_zero(bench.push(kOneNewton_un)));
  CHECK(bench.state().fault == hid::kFaultOverSpeed);
}

TEST_CASE("faster than the speed cap is a fault, while enabled only") {
  Bench bench(hid::kHasVelocity);
  hid::Config config = kConfig;
  config.v_cap_mmps = 500;
  bench.send(config);
  bench.sensors.vel[0] = 3000;
  bench.sensors.vel[1] = -4000;  // together 0.5 m/s
  REQUIRE(bench.enable());
  bench.sensors.vel[2] = 100;
  CHECK(is_zero(bench.push(kOneNewton_un)));
  CHECK(bench.state().fault == hid::kFaultOverSpeed);
  bench.send_flags(kCommandClearFault);
  bench.servo();
  CHECK(bench.state().fault == 0);
}

using Image = std::array<std::uint8_t, sizeof(HapDevice)>;

Image image_of(const HapDevice& device) {
  Image image;
  std::memcpy(image.data(), &device, sizeof device);
  return image;
}

TEST_CASE("every wrong length and every unknown ID is refused, marked, and without effect") {
  Bench bench;  // no affine command
  REQUIRE(bench.enable());
  for (unsigned id = 0; id < 256; ++id) {
    for (std::size_t length = 0; length <= 70; ++length) {
      CAPTURE(id);
      CAPTURE(length);
      const bool right = (id == 0x02 && length == 32) || (id == 0x11 && length == 16) ||
                         (id == 0x12 && length == 8);
      if (right) continue;
      bench.device.faults = 0;
      std::vector<std::uint8_t> bytes(length, 0x55);
      if (length != 0) bytes[0] = static_cast<std::uint8_t>(id);
      const Image before = image_of(bench.device);
      if (bench.receive(bytes)) FAIL("taken");
      if (bench.device.faults != kHapBadCommand) FAIL("not marked");
      bench.device.faults = 0;
      if (before != image_of(bench.device)) FAIL("with an effect");
    }
  }
  bench.receive(std::vector<std::uint8_t>(3));
  CHECK(bench.push(kOneNewton_un).motors_on);
  const hid::StateReport state = bench.state();
  CHECK(state.fault == hid::kFaultBadCommand);
  CHECK((state.status & hid::kStatusFault) == 0);
  bench.send_flags(kCommandClearFault);
  CHECK(bench.state().fault == 0);
}

TEST_CASE("a report with its ID apart is the same report") {
  Bench bench;
  bench.servo();
  for (const bool in_front : {true, false}) {
    hid::CommandReport command{.seq = ++bench.seq};
    const auto bytes = hid::encode(command);
    // The stack took the ID off, or left it in front and told it too.
    const std::size_t from = in_front ? 0 : 1;
    CHECK(hap_receive_split(&bench.device, bench.now_us, 0x02, bytes.data() + from,
                            static_cast<std::uint32_t>(bytes.size() - from)));
    CHECK(bench.state().cmd_seq == bench.seq);
  }
  const auto bytes = hid::encode(hid::CommandReport{.seq = ++bench.seq});
  CHECK(hap_receive_split(&bench.device, bench.now_us, 0, bytes.data(), 32));
  CHECK(bench.state().cmd_seq == bench.seq);
  const std::vector<std::uint8_t> longer(64, 0x02);
  CHECK_FALSE(hap_receive_split(&bench.device, bench.now_us, 0x02, longer.data(), 64));
  CHECK_FALSE(hap_receive_split(&bench.device, bench.now_us, 0x02, longer.data(), 30));
  CHECK_FALSE(hap_receive_split(&bench.device, bench.now_us, 0x02, longer.data(), 0));
}

TEST_CASE("settings that contradict the profile make a device that never enables") {
  HapSettings settings = settings_with(0);
  settings.capabilities.wd_max_ms = 101;
  Bench bench(settings);
  CHECK_FALSE(bench.sound);
  CHECK_FALSE(bench.enable());
  bench.send_flags(kCommandClearFault);
  CHECK_FALSE(bench.enable());
  CHECK(bench.shows(hid::kStatusFault));
}

}  // namespace
}  // namespace hapticd::test
