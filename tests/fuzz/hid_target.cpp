// See hid_target.h.
#include "tests/fuzz/hid_target.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>

#include "device/hid/profile_codec.h"
#include "device/hid/profile_units.h"
#include "device/hid/reference_firmware/hapticd_device.h"
#include "device/hid/report_descriptor.h"
#include "tests/device/hid/sent_reports.h"

namespace hapticd::test {
namespace {

using View = std::span<const std::uint8_t>;

void require(bool condition) {
  if (!condition) throw std::logic_error("HID bytes did what they must not");
}

/// What is read gives the same report again, and is left alone when it is refused.
template <typename Report, typename Decode>
bool check_report(View bytes, Decode decode) {
  Report report;
  if (decode(bytes, report) != hid::Decoded::kOk) {
    require(report == Report{});
    return false;
  }
  const auto again = hid::encode(report);
  require(again.size() == bytes.size() && again[0] == bytes[0]);
  Report same;
  require(decode(again, same) == hid::Decoded::kOk && same == report);
  return true;
}

bool check_descriptor(View bytes) {
  constexpr std::uint64_t kMax = 16384 + 1;
  const hid::DescriptorFacts facts = hid::read_descriptor(bytes);
  bool affine = false;
  const bool profile = hid::is_profile_v1(facts, &affine);
  require(facts.is_haptic || !profile);
  require(profile || !affine);
  for (const hid::ReportSize& report : facts.reports) require(hid::bytes_of(report) <= kMax);
  if (facts.flaw == DescriptorFlaw::kNone) return true;
  require(!facts.is_haptic && facts.reports.empty());
  return false;
}

void check_sample(View bytes) {
  hid::StateReport state;
  if (hid::decode_state(bytes, state) != hid::Decoded::kOk) return;
  DeviceSample sample;
  hid::to_sample(state, {}, sample);
  double square = 0.0;
  for (const double component : sample.q_DH) square += component * component;
  constexpr double kUnit = 1e-6;
  require(square > 1.0 - kUnit && square < 1.0 + kUnit);
}

/// Enabled, 9 N and 0.3 N m at most, all that can be had.
HapDevice enabled_device(const HapMeasurement& sensors) {
  HapSettings settings{};
  settings.capabilities.caps = kHapCanAffine | kHapHasBrake | kHapCanGravity | kHapHasVelocity;
  settings.capabilities.dof = 0x3FFF;
  settings.capabilities.in_rate_hz = 1000;
  settings.capabilities.wd_default_ms = 20;
  settings.capabilities.wd_max_ms = 100;
  settings.capabilities.f_peak_cn = 900;
  settings.capabilities.tau_peak_mnm = 300;
  settings.capabilities.k_max_npm = 65'535;
  settings.grip_peak_mn = 1000;
  HapDevice device;
  require(hap_init(&device, &settings));
  HapOutput output;
  hap_servo(&device, 0, &sensors, &output);
  hap_sample(&device);
  const hid::CommandReport zero{.flags = hid::kCommandEnable, .seq = 1};
  const auto report = hid::encode(zero);
  require(hap_receive(&device, 0, report.data(), static_cast<std::uint32_t>(report.size())));
  require(device.enabled);
  return device;
}

void check_output(const HapDevice& device, const HapOutput& output) {
  constexpr std::int64_t kPeakForce_un = 9'000'000;
  constexpr std::int64_t kPeakTorque_unm = 300'000;
  std::int64_t force = 0;
  std::int64_t torque = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    force += std::int64_t{output.force_un[i]} * output.force_un[i];
    torque += std::int64_t{output.torque_unm[i]} * output.torque_unm[i];
  }
  require(force <= kPeakForce_un * kPeakForce_un && torque <= kPeakTorque_unm * kPeakTorque_unm);
  const bool nothing = force == 0 && torque == 0 && output.grip_mn == 0 && !output.brake &&
                       !output.gravity && !output.motors_on;
  require(device.enabled || nothing);
}

void check_firmware(View bytes) {
  HapMeasurement sensors{};
  sensors.quat_q30[0] = 1 << 30;
  sensors.bus_ready = true;
  HapDevice device = enabled_device(sensors);
  while (!bytes.empty()) {
    const std::size_t length = std::min<std::size_t>(bytes[0], bytes.size() - 1);
    const View report = bytes.subspan(1, length);
    bytes = bytes.subspan(1 + length);
    hap_receive(&device, sensors.t_us, report.data(), static_cast<std::uint32_t>(length));
    // The device moves with what it is told.
    for (std::size_t i = 0; i < std::min<std::size_t>(3, length / 4); ++i) {
      std::memcpy(&sensors.pos_nm[i], report.data() + 4 * i, sizeof sensors.pos_nm[i]);
      sensors.vel[i] = static_cast<std::int16_t>(report[i] * 256 - 32'768);
    }
    sensors.t_us += 1000;
    HapOutput output;
    hap_servo(&device, sensors.t_us, &sensors, &output);
    check_output(device, output);
    hap_sample(&device);
  }
}

}  // namespace

bool check_hid_bytes(View bytes) {
  bool taken = check_report<hid::StateReport>(bytes, hid::decode_state);
  taken |= check_report<hid::CommandReport>(bytes, decode_command);
  taken |= check_report<hid::AffineReport>(bytes, decode_affine);
  taken |= check_report<hid::Capabilities>(bytes, hid::decode_capabilities);
  taken |= check_report<hid::Config>(bytes, hid::decode_config);
  taken |= check_report<hid::Calibration>(bytes, hid::decode_calibration);
  taken |= check_descriptor(bytes);
  check_sample(bytes);
  check_firmware(bytes);
  return taken;
}

}  // namespace hapticd::test
