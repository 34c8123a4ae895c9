// A device attached as the daemon does it, with a loop at 1 kHz that reads and writes it: what the
// suites in a guest share. Units: device_sample.h. Not RT.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "device/hid/hid_device.h"
#include "device/report_io/hidraw_handles.h"

namespace hapticd::test {

/// Waits until this instant of CLOCK_MONOTONIC.
void sleep_until(std::int64_t t_ns);

/// Waits so long.
void sleep_ms(int ms);

/// The devices of profile v1 that are plugged in.
[[nodiscard]] std::vector<HidrawNode> find_devices();

/// Waits until a device of this serial is there. A failed test after some seconds.
HidrawNode appears(const std::string& serial);

/// Waits until no device of this serial is there. A failed test after some seconds.
void disappears(const std::string& serial);

struct AttachedLoop {
  /// Opens it, asks what it is, agrees on its limits.
  explicit AttachedLoop(const std::string& serial = "A1");
  /// The same with a device that is open.
  explicit AttachedLoop(const ReportChannel& channel) { begin(channel); }
  ~AttachedLoop() { device->detach(); }
  AttachedLoop(const AttachedLoop&) = delete;
  AttachedLoop& operator=(const AttachedLoop&) = delete;

  /// Asks an open device what it is, agrees on its limits, lets the loop at it.
  void begin(const ReportChannel& channel);
  /// Opens the device of this serial wherever it is now.
  void open(const std::string& serial);
  /// Lets go of a lost device, and goes on with the one of this serial.
  void reopen(const std::string& serial);
  /// One tick: reads, and writes a force along y, N.
  ReadOutcome tick(double force, bool enable);
  /// So many ticks at 1 kHz, half a millisecond after a sample if there are any: at the edge of a
  /// frame it is chance whose sample a tick gets. How many had a fresh one.
  int run(int ticks, double force = 0.0, bool enable = false);

  HidrawNode node;
  std::optional<HidrawHandles> handles;
  std::optional<hid::HidDevice> device;
  DeviceSample sample;
  ReadOutcome outcome = ReadOutcome::kNothing;
  bool written = false;  ///< what the last write said
  std::uint64_t fresh = 0;
  std::vector<std::int64_t> ages;   ///< of each fresh sample when it was read, ns
  std::vector<std::int64_t> costs;  ///< of reading a fresh sample and writing, ns
};

}  // namespace hapticd::test
