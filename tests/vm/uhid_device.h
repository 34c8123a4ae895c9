// A haptic device made of the reference firmware and the kernel's uhid: to every other program it
// is a USB device that was plugged in. Runs in a thread of its own at the frame rate asked for, by
// the monotonic clock. Needs /dev/uhid, so mostly a guest (guest.py). Not RT.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "tests/vm/plugged_firmware.h"

struct uhid_event;  // NOLINT(readability-identifier-naming): the kernel's

namespace hapticd::test {

using UhidOptions = FirmwareOptions;
using UhidFaults = FirmwareFaults;

class UhidDevice {
 public:
  /// Plugs it in. Throws std::system_error without /dev/uhid.
  explicit UhidDevice(const UhidOptions& options, Motion motion = {});
  /// Unplugs it.
  ~UhidDevice();
  UhidDevice(const UhidDevice&) = delete;
  UhidDevice& operator=(const UhidDevice&) = delete;

  void set_rate(int rate_hz) { rate_hz_ = rate_hz; }
  /// These as of PluggedFirmware.
  void set(const UhidFaults& faults) { firmware_.set(faults); }
  [[nodiscard]] int stored() const { return firmware_.stored(); }
  [[nodiscard]] HapOutput output() const { return firmware_.output(); }
  [[nodiscard]] std::uint8_t status() const { return firmware_.status(); }
  [[nodiscard]] std::uint64_t frames() const { return firmware_.frames(); }
  [[nodiscard]] std::uint64_t commands() const { return firmware_.commands(); }
  [[nodiscard]] std::uint64_t springs() const { return firmware_.springs(); }
  /// When the newest sample was taken, by the monotonic clock, ns.
  [[nodiscard]] std::int64_t sampled_ns() const { return sampled_ns_; }
  /// Frames that the kernel kept from beginning in time: after each the loop may get two at once.
  [[nodiscard]] std::uint64_t held_up() const { return held_up_; }
  [[nodiscard]] std::uint64_t since_force_us() const { return firmware_.since_force_us(); }

 private:
  void create(const UhidOptions& options) const;
  void run();
  void frame();
  void take_events();
  void answer(const uhid_event& event);

  PluggedFirmware firmware_;
  int uhid_ = -1;
  std::atomic<int> rate_hz_;
  std::atomic<std::int64_t> sampled_ns_{0};
  std::atomic<std::uint64_t> held_up_{0};
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace hapticd::test
