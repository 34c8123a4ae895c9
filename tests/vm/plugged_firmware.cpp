// See plugged_firmware.h.
#include "tests/vm/plugged_firmware.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/rt/monotonic_clock.h"

namespace hapticd::test {
namespace {

HapSettings settings_of(const FirmwareOptions& options) {
  HapSettings settings{};
  HapCapabilities& c = settings.capabilities;
  c.n_buttons = 2;
  c.caps = kHapHasVelocity | kHapCanAffine;
  c.dof = 0x0FFF;
  c.in_rate_hz = static_cast<std::uint16_t>(options.rate_hz);
  c.servo_rate_hz = 8000;
  c.wd_default_ms = 20;
  c.wd_max_ms = 100;
  c.f_cont_cn = 300;
  c.f_peak_cn = 900;
  c.tau_cont_mnm = 100;
  c.tau_peak_mnm = 300;
  c.k_max_npm = 3000;
  for (int k = 0; k < 3; ++k) {
    c.ws_min_mm[k] = -150;
    c.ws_max_mm[k] = 150;
  }
  c.pos_res_nm = 1;
  c.rot_res_urad = 1;
  c.mass_g = 120;
  if (options.needs_calibration) {
    c.caps |= kHapNeedsCalibration;
    settings.calibration_axes = 0x3F;
  }
  return settings;
}

}  // namespace

std::vector<std::uint8_t> report_descriptor(const FirmwareOptions& options) {
  if (!options.descriptor.empty()) return options.descriptor;
  std::uint16_t length = 0;
  const std::uint8_t* bytes = hap_report_descriptor(true, &length);
  return {bytes, bytes + length};
}

PluggedFirmware::PluggedFirmware(const FirmwareOptions& options, Motion motion)
    : options_(options), motion_(std::move(motion)), begin_ns_(monotonic_now_ns()) {
  const HapSettings settings = settings_of(options);
  if (!hap_init(&device_, &settings)) throw std::logic_error("the firmware refuses its settings");
  device_.seq = options.begin_seq;
  device_.settings.capabilities.magic = options.magic;
  device_.settings.capabilities.ver_major = options.version;
  hap_bus_reset(&device_);
}

std::int64_t PluggedFirmware::elapsed_ns() const { return monotonic_now_ns() - begin_ns_; }

std::uint32_t PluggedFirmware::now_us() const {
  return options_.begin_us + static_cast<std::uint32_t>(elapsed_ns() / 1000);
}

void PluggedFirmware::reset() {
  const std::lock_guard lock(mutex_);
  hap_bus_reset(&device_);
}

// As a maker's main loop does.
void PluggedFirmware::calibrate() {
  constexpr std::int64_t kCalibration_ns = 500'000'000;
  std::uint16_t axes = 0;
  const std::uint8_t asked = hap_take_calibration(&device_, &axes);
  if (asked == kHapStart) calibrating_ns_ = elapsed_ns();
  if (asked == kHapStore) ++stored_;
  const std::int64_t since_ns = elapsed_ns() - calibrating_ns_;
  if (since_ns >= kCalibration_ns) hap_calibration_end(&device_, true);
  hap_calibration_progress(&device_, static_cast<std::uint8_t>(100 * since_ns / kCalibration_ns));
}

void PluggedFirmware::frame() {
  const std::lock_guard lock(mutex_);
  calibrate();
  const double t_s = 1e-9 * static_cast<double>(elapsed_ns());
  HapMeasurement now{};
  now.t_us = now_us();
  now.quat_q30[0] = 1 << 30;
  const std::array<double, 3> p = motion_ ? motion_(t_s, output_) : std::array<double, 3>{};
  for (std::size_t k = 0; k < 3; ++k) {
    now.pos_nm[k] = static_cast<std::int32_t>(std::lround(1e9 * p[k]));
  }
  now.temp_c = 0xFF;
  now.bus_ready = true;
  now.dead_man_held = faults_.dead_man;
  now.emergency_stop = faults_.emergency;
  now.faults = faults_.faults;
  hap_servo(&device_, now.t_us, &now, &output_);
  const std::int32_t* f = output_.force_un;
  if (f[0] != 0 || f[1] != 0 || f[2] != 0) last_force_ns_ = elapsed_ns();
  hap_sample(&device_);
}

bool PluggedFirmware::take(HapState& report) {
  const std::lock_guard lock(mutex_);
  if (faults_.silent || !hap_take_report(&device_, &report)) return false;
  status_ = report.status;
  ++frames_;
  return true;
}

bool PluggedFirmware::receive(const std::uint8_t* report, std::uint32_t length) {
  const std::lock_guard lock(mutex_);
  if (length > 0 && (report[0] == kHapCommandId || report[0] == kHapAffineId)) ++commands_;
  const bool taken = hap_receive(&device_, now_us(), report, length);
  if (taken && report[0] == kHapAffineId) ++springs_;
  return taken;
}

std::uint32_t PluggedFirmware::get_feature(std::uint8_t id, std::uint8_t* report,
                                           std::uint32_t room) const {
  const std::lock_guard lock(mutex_);
  return hap_get_feature(&device_, id, report, room);
}

void PluggedFirmware::set(const FirmwareFaults& faults) {
  const std::lock_guard lock(mutex_);
  faults_ = faults;
}

int PluggedFirmware::stored() const {
  const std::lock_guard lock(mutex_);
  return stored_;
}

HapOutput PluggedFirmware::output() const {
  const std::lock_guard lock(mutex_);
  return output_;
}

std::uint8_t PluggedFirmware::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

std::uint64_t PluggedFirmware::frames() const {
  const std::lock_guard lock(mutex_);
  return frames_;
}

std::uint64_t PluggedFirmware::commands() const {
  const std::lock_guard lock(mutex_);
  return commands_;
}

std::uint64_t PluggedFirmware::springs() const {
  const std::lock_guard lock(mutex_);
  return springs_;
}

std::uint64_t PluggedFirmware::since_force_us() const {
  const std::lock_guard lock(mutex_);
  if (last_force_ns_ < 0) return std::numeric_limits<std::uint64_t>::max();
  return static_cast<std::uint64_t>((elapsed_ns() - last_force_ns_) / 1000);
}

}  // namespace hapticd::test
