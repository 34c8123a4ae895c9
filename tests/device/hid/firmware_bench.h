// The reference firmware on a bench: a clock, sensors to set, and a host that speaks through the
// codec of device/hid, so that two independent implementations of the layout meet in every test.
#pragma once

#include <doctest/doctest.h>

#include <cstdint>
#include <cstring>
#include <vector>

#include "device/hid/profile_codec.h"
#include "device/hid/reference_firmware/hapticd_device.h"
#include "tests/device/hid/worked_reports.h"

namespace hapticd::test {

/// The device of the worked Capabilities, with `caps` bits instead of its own.
inline HapSettings settings_with(std::uint32_t caps) {
  hid::Capabilities capabilities = kCapabilities;
  capabilities.caps = caps;
  HapSettings settings{};
  const auto bytes = hid::encode(capabilities);
  std::memcpy(&settings.capabilities, bytes.data(), bytes.size());
  settings.calibration_axes = 0x3F;
  settings.grip_peak_mn = 2000;
  return settings;
}

class Bench {
 public:
  explicit Bench(std::uint32_t caps = 0) : Bench(settings_with(caps)) {}
  explicit Bench(const HapSettings& settings) {
    sound = hap_init(&device, &settings);
    sensors.quat_q30[0] = 1 << 30;
    sensors.bus_ready = true;
  }

  /// The host sends bytes.
  template <typename Bytes>
  bool receive(const Bytes& bytes) {
    return hap_receive(&device, now_us, std::data(bytes), static_cast<std::uint32_t>(bytes.size()));
  }
  /// A report with the next seq.
  bool send(hid::CommandReport command) {
    command.seq = ++seq;
    return receive(hid::encode(command));
  }
  bool send(hid::AffineReport affine) {
    affine.base.seq = ++seq;
    return receive(hid::encode(affine));
  }
  bool send(const hid::Config& config) { return receive(hid::encode(config)); }
  bool send(hid::CalibrationOp op, std::uint16_t axes = 0) {
    return receive(hid::encode(hid::Calibration{.op = op, .axis_mask = axes}));
  }
  bool send_flags(unsigned flags) {
    return send(hid::CommandReport{.flags = static_cast<std::uint8_t>(flags)});
  }

  /// A servo cycle, `later_us` after the one before.
  HapOutput servo(std::uint32_t later_us = 125) {
    now_us += later_us;
    sensors.t_us = now_us;
    HapOutput output{};
    hap_servo(&device, now_us, &sensors, &output);
    return output;
  }
  /// The report of this moment, as the host reads it.
  hid::StateReport state() {
    hap_sample(&device);
    HapState report;
    REQUIRE(hap_take_report(&device, &report));
    std::array<std::uint8_t, sizeof report> bytes{};
    std::memcpy(bytes.data(), &report, sizeof report);
    hid::StateReport read;
    REQUIRE(hid::decode_state(bytes, read) == hid::Decoded::kOk);
    return read;
  }
  [[nodiscard]] bool shows(unsigned status) { return (state().status & status) == status; }

  /// The way a host enables, without asserting that it works.
  bool enable() {
    servo();
    send_flags(0);
    send_flags(hid::kCommandEnable);
    servo();
    return device.enabled;
  }
  /// A force along x, enabled, in the next servo cycle.
  HapOutput push(std::int32_t force_un) {
    send(hid::CommandReport{.flags = hid::kCommandEnable, .force_un = {force_un, 0, 0}});
    return servo();
  }
  hid::Config config() {
    hid::Config config;
    REQUIRE(hid::decode_config(feature(kHapConfigId), config) == hid::Decoded::kOk);
    return config;
  }
  hid::Calibration calibration() {
    hid::Calibration calibration;
    REQUIRE(hid::decode_calibration(feature(kHapCalibrationId), calibration) == hid::Decoded::kOk);
    return calibration;
  }
  std::vector<std::uint8_t> feature(std::uint8_t id) {
    std::vector<std::uint8_t> bytes(kHapReportBytes);
    bytes.resize(hap_get_feature(&device, id, bytes.data(), kHapReportBytes));
    return bytes;
  }

  HapDevice device{};
  HapMeasurement sensors{};
  std::uint32_t now_us = 0;
  std::uint16_t seq = 0;
  bool sound = false;
};

inline bool is_zero(const HapOutput& output) {
  bool zero = output.grip_mn == 0 && !output.motors_on && !output.brake && !output.gravity;
  for (std::size_t i = 0; i < 3; ++i) {
    zero = zero && output.force_un[i] == 0 && output.torque_unm[i] == 0;
  }
  return zero;
}

}  // namespace hapticd::test
