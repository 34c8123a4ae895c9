// The reference firmware as a device that is plugged in somewhere: its clock is the monotonic one,
// its handle moves as a test wants, and whatever brings its reports to a host (uhid_device.h,
// usbip_device.h) calls it. Each function may be called by any thread. Not RT.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "device/hid/reference_firmware/hapticd_device.h"

namespace hapticd::test {

struct FirmwareOptions {
  std::string serial = "A1";
  int rate_hz = 1000;
  std::uint16_t vendor_id = 0x1209;  ///< with 0001 the number for tests
  std::uint16_t product_id = 0x0001;
  std::vector<std::uint8_t> descriptor;  ///< of its reports; empty: the firmware's
  std::uint32_t begin_us = 0;            ///< first t_us: near 2^32 it wraps soon
  std::uint16_t begin_seq = 0;           ///< first seq
  std::uint32_t magic = kHapMagic;
  std::uint8_t version = kHapVersionMajor;
  bool needs_calibration = false;  ///< half a second, once it is asked for
};

/// What happens to a device from outside.
struct FirmwareFaults {
  bool silent = false;     ///< sends no reports
  bool dead_man = true;    ///< held
  bool emergency = false;  ///< pressed
  std::uint16_t faults = 0;
};

/// The report descriptor of a device with these options.
[[nodiscard]] std::vector<std::uint8_t> report_descriptor(const FirmwareOptions& options);

/// Where the handle is, m, and what its motors gave until then.
using Motion = std::function<std::array<double, 3>(double t_s, const HapOutput& output)>;

class PluggedFirmware {
 public:
  /// Switched on, the bus reset. Throws std::logic_error when the firmware refuses its settings.
  explicit PluggedFirmware(const FirmwareOptions& options, Motion motion = {});

  /// The host has reset the bus or configured it anew.
  void reset();
  /// One frame: a servo cycle and a sample.
  void frame();
  /// The report that waits for the endpoint; false when there is none.
  bool take(HapState& report);
  /// A report from the host, ID first; false when it was refused.
  bool receive(const std::uint8_t* report, std::uint32_t length);
  /// Feature report `id`, ID first; its length, 0 when there is none.
  std::uint32_t get_feature(std::uint8_t id, std::uint8_t* report, std::uint32_t room) const;

  void set(const FirmwareFaults& faults);
  /// Calibrations that the host wanted kept.
  [[nodiscard]] int stored() const;
  /// What the motors give.
  [[nodiscard]] HapOutput output() const;
  /// Status byte of the newest report that was taken.
  [[nodiscard]] std::uint8_t status() const;
  /// Reports taken.
  [[nodiscard]] std::uint64_t frames() const;
  /// Commands received, good or bad.
  [[nodiscard]] std::uint64_t commands() const;
  /// Those among them that were affine and taken.
  [[nodiscard]] std::uint64_t springs() const;
  /// Microseconds since a force was last given; never: the largest.
  [[nodiscard]] std::uint64_t since_force_us() const;

 private:
  [[nodiscard]] std::int64_t elapsed_ns() const;
  [[nodiscard]] std::uint32_t now_us() const;

  FirmwareOptions options_;
  Motion motion_;
  std::int64_t begin_ns_ = 0;
  mutable std::mutex mutex_;
  HapDevice device_{};
  HapOutput output_{};
  FirmwareFaults faults_;
  std::uint8_t status_ = 0;
  std::uint64_t frames_ = 0;
  std::uint64_t commands_ = 0;
  std::uint64_t springs_ = 0;
  void calibrate();

  std::int64_t last_force_ns_ = -1;  ///< -1: never
  std::int64_t calibrating_ns_ = 0;  ///< since when, where a calibration runs
  int stored_ = 0;
};

}  // namespace hapticd::test
