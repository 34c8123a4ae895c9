// The HID driver against a USB device: enumeration, endpoints, stalls and plugs are those of the
// kernel's usbcore and usbhid. Runs in a guest, where time is exact. Truth: the device's own
// firmware, which counts what it was told, and the USB and HID specifications.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <linux/hidraw.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "core/rt/monotonic_clock.h"
#include "device/hid/device_features.h"
#include "tests/vm/attached_loop.h"
#include "tests/vm/usbip_device.h"

namespace hapticd::test {
namespace {

/// Ticks until the loop is told that the device does not take its commands: kStuckAfter_ns, and
/// one.
constexpr int kTicksUntilStuck = 6;

/// The folder in sysfs of the USB device behind a node.
std::filesystem::path usb_folder(const HidrawNode& node) {
  namespace fs = std::filesystem;
  fs::path place = "/sys/class/hidraw" / fs::path(node.path).filename() / "device";
  for (place = fs::canonical(place); !fs::exists(place / "idVendor"); place = place.parent_path()) {
    REQUIRE(place.has_relative_path());
  }
  return place;
}

std::string line_of(const std::filesystem::path& path) {
  std::string line;
  std::getline(std::ifstream(path) >> std::ws, line);
  return line;
}

/// errno of asking for a feature report; 0 when it is given.
int error_of_feature(const HidrawNode& node, std::uint8_t id) {
  const int file = open(node.path.c_str(), O_RDWR | O_CLOEXEC);
  REQUIRE(file >= 0);
  std::array<std::uint8_t, 64> bytes{id};
  const int got = ioctl(file, HIDIOCGFEATURE(bytes.size()), bytes.data());
  const int error = got < 0 ? errno : 0;
  close(file);
  return error;
}

/// Ticks until the loop is told, at most `most`.
template <typename Told>
int ticks_until(AttachedLoop& loop, int most, Told told) {
  int ticks = 0;
  while (ticks < most) {
    sleep_ms(1);
    loop.tick(0.5, true);
    ++ticks;
    if (told()) break;
  }
  return ticks;
}

}  // namespace

TEST_CASE("USB enumerates it: strings, serial, speed, and no autosuspend once it is open") {
  UsbipDevice plugged({});
  std::ofstream(usb_folder(appears("A1")) / "power/control") << "auto";
  AttachedLoop loop;
  CHECK(loop.node.maker == "hapticd");
  CHECK(loop.node.product == "reference device");
  CHECK(loop.node.vendor_id == 0x1209);
  CHECK(loop.node.product_id == 0x0001);
  CHECK(line_of(usb_folder(loop.node) / "speed") == "12");
  CHECK(line_of(usb_folder(loop.node) / "power/control") == "on");
}

TEST_CASE("over USB three seconds at 1 kHz lose no sample and use none that is old") {
  UsbipDevice plugged({});
  AttachedLoop loop;
  loop.run(100);
  loop.ages.clear();
  const hid::HidCounters before = loop.device->counters();
  const int fresh = loop.run(3000, 0.5, true);
  const hid::HidCounters after = loop.device->counters();
  CHECK(fresh >= 2995);
  CHECK(after.lost == before.lost);
  CHECK(after.too_old == before.too_old);
  CHECK(after.overflows == 0);
  CHECK(after.malformed == 0);
  CHECK(plugged.firmware().output().force_un[1] == 500'000);
  std::sort(loop.ages.begin(), loop.ages.end());
  std::printf("age us: p50 %.0f max %.0f; delay %.0f us; fresh %d\n",
              1e-3 * static_cast<double>(loop.ages[loop.ages.size() / 2]),
              1e-3 * static_cast<double>(loop.ages.back()), 1e6 * loop.sample.measured_delay_s,
              fresh);
  CHECK(loop.sample.measured_delay_s > 0.0);
  CHECK(loop.sample.measured_delay_s < 3e-3);
}

TEST_CASE("at high speed 8000 reports a second are read by a loop of 1 kHz, always the newest") {
  FirmwareOptions options;
  options.rate_hz = 8000;
  UsbipDevice plugged(options, UsbSpeed::kHigh);
  AttachedLoop loop;
  loop.run(100);
  const auto before = loop.device->counters();
  CHECK(loop.run(1000, 0.5, true) >= 995);
  const auto after = loop.device->counters();
  std::printf("8 kHz: lost %llu, superseded %llu\n",
              static_cast<unsigned long long>(after.lost - before.lost),
              static_cast<unsigned long long>(after.superseded - before.superseded));
  CHECK(after.lost - before.lost <= 8);  // one in a thousand
  CHECK(after.superseded - before.superseded > 6500);
  CHECK(after.overflows == 0);
}

TEST_CASE("a hung OUT endpoint is reported within 6 ticks and never stops the reading") {
  UsbipDevice plugged({});
  AttachedLoop loop;
  loop.run(200, 0.5, true);
  REQUIRE(loop.written);
  REQUIRE((plugged.firmware().status() & kHapEnabled) != 0);
  plugged.hang_output(true);
  CHECK(ticks_until(loop, 100, [&] { return !loop.written; }) <= kTicksUntilStuck);
  // The system gives the write up after 5 s.
  CHECK(loop.run(4900, 0.5, true) >= 4890);
  CHECK_FALSE(loop.device->failed());
  CHECK(plugged.waiting_outputs() == 1);
  CHECK((plugged.firmware().status() & kHapWatchdog) != 0);
  CHECK(plugged.firmware().since_force_us() > 4'800'000);
  const int ticks = ticks_until(loop, 500, [&] { return loop.outcome == ReadOutcome::kLost; });
  std::printf("hung: given up %d ticks after 4.9 s\n", ticks);
  CHECK(loop.device->failed());
  CHECK_FALSE(loop.written);

  plugged.hang_output(false);
  loop.reopen("A1");
  CHECK(loop.run(100) >= 98);
  CHECK(loop.written);
}

TEST_CASE(
    "unplugged while a write is stuck, the loop knows within 2 ticks and the writer is free") {
  std::optional<UsbipDevice> plugged;
  plugged.emplace(FirmwareOptions{});
  AttachedLoop loop;
  loop.run(100, 0.5, true);
  plugged->hang_output(true);
  loop.run(50, 0.5, true);
  REQUIRE(plugged->waiting_outputs() == 1);
  REQUIRE_FALSE(loop.device->failed());
  plugged.reset();
  const auto is_lost = [&] { return loop.outcome == ReadOutcome::kLost; };
  CHECK(ticks_until(loop, 100, is_lost) <= 2);
  const std::int64_t before_ns = monotonic_now_ns();
  loop.device->detach();
  CHECK(monotonic_now_ns() - before_ns < 10'000'000);
}

TEST_CASE("an unknown feature and a stalled one are refused with EPIPE, and the loop goes on") {
  UsbipDevice plugged({});
  AttachedLoop loop;
  CHECK(error_of_feature(loop.node, kHapCapabilitiesId) == 0);
  CHECK(error_of_feature(loop.node, 0x55) == EPIPE);
  plugged.stall_feature(kHapConfigId);
  CHECK(error_of_feature(loop.node, kHapConfigId) == EPIPE);
  hid::Config config;
  std::string error;
  CHECK_FALSE(agree(loop.handles->channel(), config, error));
  CHECK(error == "it does not take its feature report 17");
  CHECK(loop.run(50, 0.0) >= 48);
}

TEST_CASE(
    "reports of another length or ID reach the device, which refuses them and keeps its force") {
  UsbipDevice plugged({});
  AttachedLoop loop;
  loop.run(200, 0.5, true);
  const int file = open(loop.node.path.c_str(), O_RDWR | O_CLOEXEC);
  REQUIRE(file >= 0);
  const std::uint64_t before = plugged.firmware().commands();
  const std::array<std::uint8_t, 64> all_force = [] {
    std::array<std::uint8_t, 64> bytes{};
    bytes.fill(0x7F);
    return bytes;
  }();
  const auto send = [&](std::uint8_t id, std::size_t length) {
    std::array<std::uint8_t, 64> bytes = all_force;
    bytes[0] = id;
    CHECK(write(file, bytes.data(), length) == static_cast<ssize_t>(length));
  };
  send(kHapCommandId, 8);
  send(kHapCommandId, 64);
  send(kHapAffineId, 32);
  send(0x55, 32);
  close(file);
  CHECK(plugged.firmware().commands() >= before + 4);
  CHECK(plugged.firmware().output().force_un[1] == 500'000);
  CHECK((plugged.firmware().status() & (kHapFault | kHapWatchdog)) == 0);
  CHECK(loop.run(50, 0.5, true) >= 48);
  CHECK(plugged.firmware().output().force_un[1] == 500'000);
}

TEST_CASE("unplugged in the middle it is lost within 2 ticks; plugged in again it goes on") {
  std::optional<UsbipDevice> plugged;
  plugged.emplace(FirmwareOptions{});
  AttachedLoop loop;
  loop.run(100, 0.5, true);
  plugged.reset();
  CHECK(ticks_until(loop, 100, [&] { return loop.outcome == ReadOutcome::kLost; }) <= 2);
  CHECK(loop.device->failed());
  plugged.emplace(FirmwareOptions{});
  loop.reopen("A1");
  const std::uint64_t counter = loop.sample.counter;
  CHECK(loop.run(100, 0.5, true) >= 95);
  CHECK(loop.sample.counter > counter);
  CHECK((plugged->firmware().status() & kHapEnabled) != 0);
}

}  // namespace hapticd::test
