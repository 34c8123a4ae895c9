// Everything that touches a HID device at once: loop, writer, guardian, watcher, and a hand that
// plugs and unplugs it. Runs in a guest with two processors that really run at once, built with the
// thread sanitizer. No time is asserted: there time is the host's. Truth: the device's firmware,
// and the sanitizer.
#include <doctest/doctest.h>

#include <atomic>
#include <cstdio>
#include <optional>
#include <thread>

#include "core/rt/monotonic_clock.h"
#include "tests/vm/attached_loop.h"
#include "tests/vm/uhid_device.h"
#include "tests/vm/usbip_device.h"

namespace hapticd::test {
namespace {

/// Samples between two plugs.
constexpr std::uint64_t kSamplesPerPlug = 10;
/// How long those samples may take to come, ns.
constexpr std::int64_t kPatience_ns = 20'000'000'000;

/// The threads beside the hand's; they end with this.
class Crowd {
 public:
  explicit Crowd(AttachedLoop& loop) : loop_(loop) {
    loop_thread_ = std::thread([this] { run_loop(); });
    guardian_ = std::thread([this] { run_guardian(); });
    watcher_ = std::thread([this] { run_watcher(); });
  }
  ~Crowd() {
    ending_ = true;
    loop_thread_.join();
    guardian_.join();
    watcher_.join();
  }
  Crowd(const Crowd&) = delete;
  Crowd& operator=(const Crowd&) = delete;

  [[nodiscard]] std::uint64_t fresh() const { return fresh_; }
  [[nodiscard]] std::uint64_t lost() const { return lost_; }
  /// Waits for kSamplesPerPlug samples newer than now.
  [[nodiscard]] bool goes_on() const {
    const std::uint64_t enough = fresh_ + kSamplesPerPlug;
    const std::int64_t until_ns = monotonic_now_ns() + kPatience_ns;
    while (fresh_ < enough && monotonic_now_ns() < until_ns) sleep_ms(1);
    return fresh_ >= enough;
  }

 private:
  void run_loop() {
    while (!ending_) {
      const ReadOutcome outcome = loop_.tick(0.5, true);
      if (outcome == ReadOutcome::kFresh) ++fresh_;
      if (outcome == ReadOutcome::kLost) ++lost_;
      loop_.ages.clear();
      loop_.costs.clear();
      std::this_thread::yield();
    }
  }
  void run_guardian() {
    while (!ending_) {
      loop_.device->write_zero(monotonic_now_ns());
      sleep_ms(1);
    }
  }
  void run_watcher() {
    while (!ending_) {
      if (loop_.device->failed()) ++failures_;
      samples_ = loop_.device->counters().samples;
      sleep_ms(1);
    }
  }

  AttachedLoop& loop_;
  std::atomic<bool> ending_{false};
  std::atomic<std::uint64_t> fresh_{0}, lost_{0};
  std::uint64_t failures_ = 0;  ///< watcher's
  std::uint64_t samples_ = 0;   ///< watcher's
  std::thread loop_thread_, guardian_, watcher_;
};

/// Plugs and unplugs a device so often while all others are at it.
template <typename Device>
void plug_and_unplug(int times) {
  std::optional<Device> plugged;
  plugged.emplace(FirmwareOptions{});
  AttachedLoop loop;
  Crowd crowd(loop);
  for (int k = 0; k < times; ++k) {
    CHECK(crowd.goes_on());
    // In turn the plug first, as people do it, and the driver first, as the daemon ends.
    if (k % 2 == 0) plugged.reset();
    loop.device->detach();
    // A node that is closed in the moment of its unplugging can hang the kernel's virtual bus:
    // vhci_hcd of 6.1 loses the transfer that both take back.
    if (!plugged) disappears("A1");
    loop.handles.reset();
    plugged.reset();
    // Else the node that is opened next may be the one that goes.
    disappears("A1");
    plugged.emplace(FirmwareOptions{});
    loop.reopen("A1");
  }
  CHECK(crowd.goes_on());
  CHECK(crowd.lost() > 0);
  std::printf("%llu samples\n", static_cast<unsigned long long>(crowd.fresh()));
}

}  // namespace

TEST_CASE("read, written, revoked and watched while it is plugged and unplugged") {
  plug_and_unplug<UhidDevice>(8);
}

TEST_CASE("the same on USB") { plug_and_unplug<UsbipDevice>(3); }

}  // namespace hapticd::test
