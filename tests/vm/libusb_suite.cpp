// The HID driver over hidapi's libusb backend, which takes the interface from the kernel's usbhid
// and speaks to the endpoints itself: the driver knows its device by calls on bytes alone, so
// systems without hidraw need another set of four functions and nothing else. Runs in a guest,
// where time is exact. Truth: the device's own firmware.
#include <doctest/doctest.h>
#include <hidapi/hidapi.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "tests/vm/attached_loop.h"
#include "tests/vm/usbip_device.h"

namespace hapticd::test {
namespace {

hid_device* handle_of(void* pointer) noexcept { return static_cast<hid_device*>(pointer); }

/// The only device there is. One handle for both threads: this backend keeps no text of the last
/// error, which is what two threads must not share, and a claimed interface cannot be opened twice.
class LibusbHandle {
 public:
  LibusbHandle() : handle_(hid_open(0x1209, 0x0001, nullptr), hid_close) { REQUIRE(handle_); }

  [[nodiscard]] ReportChannel channel() noexcept {
    ReportChannel channel;
    channel.input = channel.output = handle_.get();
    channel.read = [](void* input, std::uint8_t* bytes, std::size_t room) noexcept {
      return hid_read_timeout(handle_of(input), bytes, room, 0);
    };
    channel.write = [](void* output, const std::uint8_t* bytes, std::size_t length) noexcept {
      return hid_write(handle_of(output), bytes, length);
    };
    channel.get_feature = [](void* output, std::uint8_t* bytes, std::size_t room) noexcept {
      return hid_get_feature_report(handle_of(output), bytes, room);
    };
    channel.set_feature = [](void* output, const std::uint8_t* bytes, std::size_t length) noexcept {
      return hid_send_feature_report(handle_of(output), bytes, length);
    };
    return channel;
  }

 private:
  std::unique_ptr<hid_device, void (*)(hid_device*)> handle_;
};

/// Whether the kernel's own driver has it: enumeration is hidapi's here, and sees no hidraw.
bool has_hidraw() { return !std::filesystem::is_empty("/sys/class/hidraw"); }

/// Waits until the kernel has enumerated what was plugged in. A failed test after some seconds.
void wait_for_it() {
  for (int k = 0; k < 200 && !has_hidraw(); ++k) sleep_ms(10);
  REQUIRE(has_hidraw());
}

/// Ends hidapi, which knows without udev only of devices that were there when it began.
struct Hidapi {
  Hidapi() { REQUIRE(hid_init() == 0); }
  ~Hidapi() { hid_exit(); }
  Hidapi(const Hidapi&) = delete;
  Hidapi& operator=(const Hidapi&) = delete;
};

}  // namespace

TEST_CASE("over libusb three seconds at 1 kHz lose no sample, and the force arrives") {
  UsbipDevice plugged({});
  wait_for_it();
  const Hidapi hidapi;
  LibusbHandle handle;
  CHECK_FALSE(has_hidraw());
  AttachedLoop loop(handle.channel());
  loop.run(100);
  loop.ages.clear();
  const hid::HidCounters before = loop.device->counters();
  const int fresh = loop.run(3000, 0.5, true);
  const hid::HidCounters after = loop.device->counters();
  CHECK(fresh >= 2995);
  CHECK(after.lost == before.lost);
  CHECK(after.too_old == before.too_old);
  CHECK(after.malformed == 0);
  CHECK(plugged.firmware().output().force_un[1] == 500'000);
  std::sort(loop.ages.begin(), loop.ages.end());
  std::printf("libusb: age us: p50 %.0f max %.0f; delay %.0f us; fresh %d\n",
              1e-3 * static_cast<double>(loop.ages[loop.ages.size() / 2]),
              1e-3 * static_cast<double>(loop.ages.back()), 1e6 * loop.sample.measured_delay_s,
              fresh);
}

TEST_CASE(
    "over libusb a hung OUT endpoint never stops the reading, and a stalled feature is refused") {
  UsbipDevice plugged({});
  wait_for_it();
  const Hidapi hidapi;
  LibusbHandle handle;
  AttachedLoop loop(handle.channel());
  plugged.stall_feature(kHapConfigId);
  std::uint8_t bytes[kMaxReport] = {kHapConfigId};
  CHECK(handle.channel().get_feature(handle.channel().output, bytes, sizeof(bytes)) == -1);
  loop.run(100, 0.5, true);
  REQUIRE(loop.written);
  plugged.hang_output(true);
  CHECK(loop.run(500, 0.5, true) >= 495);
  CHECK_FALSE(loop.written);
  CHECK((plugged.firmware().status() & kHapWatchdog) != 0);
}

TEST_CASE("over libusb it is lost within 2 ticks of being unplugged") {
  std::optional<UsbipDevice> plugged;
  plugged.emplace(FirmwareOptions{});
  wait_for_it();
  const Hidapi hidapi;
  LibusbHandle handle;
  AttachedLoop loop(handle.channel());
  loop.run(100, 0.5, true);
  REQUIRE(loop.written);
  plugged.reset();
  int ticks = 0;
  while (ticks < 100 && loop.outcome != ReadOutcome::kLost) {
    sleep_ms(1);
    loop.tick(0.5, true);
    ++ticks;
  }
  CHECK(ticks <= 2);
}

}  // namespace hapticd::test
