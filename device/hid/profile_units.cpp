// See profile_units.h.
#include "device/hid/profile_units.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/math/pose.h"

namespace hapticd::hid {
namespace {

constexpr double kNano = 1e-9;
constexpr double kMicro = 1e-6;
constexpr double kMilli = 1e-3;
constexpr double kCenti = 1e-2;
constexpr double kVelocityStep = 1e-4;           // m/s
constexpr double kGripStep = 1e-5;               // m
constexpr double kRotationalDampingStep = 1e-5;  // N m s/rad

/// Nearest whole number within the range of `Whole`, halves away from zero. `value`: finite.
template <typename Whole>
Whole nearest(double value) noexcept {
  constexpr double kLow = std::numeric_limits<Whole>::min();
  constexpr double kHigh = std::numeric_limits<Whole>::max();
  const double rounded = value < 0.0 ? value - 0.5 : value + 0.5;
  if (rounded <= kLow) return std::numeric_limits<Whole>::min();
  if (rounded >= kHigh) return std::numeric_limits<Whole>::max();
  return static_cast<Whole>(rounded);
}

/// Whole part, never above `most`; 0 for what is negative or NaN.
std::uint16_t at_most(double value, std::uint16_t most) noexcept {
  if (!(value > 0.0)) return 0;
  return value >= most ? most : static_cast<std::uint16_t>(value);
}

template <std::size_t Count>
bool all_finite(const std::array<double, Count>& values) noexcept {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

bool is_gain(const Array3& gain) noexcept {
  return all_finite(gain) && std::all_of(gain.begin(), gain.end(), [](double v) { return v >= 0; });
}

std::uint16_t flags_of(std::uint8_t status) noexcept {
  struct Pair {
    std::uint8_t status;
    std::uint16_t flag;
  };
  constexpr std::array<Pair, 7> kPairs{{{kStatusEnabled, kDeviceEnabled},
                                        {kStatusCalibrated, kDeviceCalibrated},
                                        {kStatusDeadManHeld, kDeviceDeadManHeld},
                                        {kStatusWatchdog, kDeviceWatchdogFired},
                                        {kStatusSaturated, kDeviceSaturated},
                                        {kStatusEmergencyStop, kDeviceEmergencyStop},
                                        {kStatusFault, kDeviceReportsFault}}};
  unsigned flags = kDeviceAttached;
  for (const Pair& pair : kPairs) {
    if ((status & pair.status) != 0) flags |= pair.flag;
  }
  return static_cast<std::uint16_t>(flags);
}

int count_axes(std::uint16_t dof, unsigned first) noexcept {
  constexpr unsigned kSixAxes = 0x3F;
  return std::popcount((static_cast<unsigned>(dof) >> first) & kSixAxes);
}

}  // namespace

void to_sample(const StateReport& state, const Capabilities& capabilities,
               DeviceSample& sample) noexcept {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  sample.has_velocity = (capabilities.caps & kHasVelocity) != 0;
  for (std::size_t i = 0; i < 3; ++i) {
    sample.p_DH[i] = kNano * state.pos_nm[i];
    sample.v_DH_D[i] = sample.has_velocity ? kVelocityStep * state.vel_100ums[i] : 0.0;
    sample.w_DH_D[i] = sample.has_velocity ? kMilli * state.avel_mradps[i] : 0.0;
  }
  Array4 q_DH{};
  for (std::size_t i = 0; i < 4; ++i) {
    q_DH[i] = static_cast<double>(state.quat_q30[i]) / kOneQ30;
  }
  sample.q_DH = to_array(renormalised(to_quaternion(q_DH)));
  const bool has_grip = (capabilities.dof & kGripSensed) != 0;
  sample.grip_m = has_grip ? static_cast<float>(kGripStep * state.grip_10um) : kNone;
  const bool has_temperature =
      (capabilities.caps & kHasTemperature) != 0 && state.temp_deg_c != kUnknownTemperature;
  sample.temperature_deg_c = has_temperature ? static_cast<float>(state.temp_deg_c) : kNone;
  sample.buttons = state.buttons;
  sample.flags = flags_of(state.status);
}

bool to_command(const DeviceCommand& command, CommandReport& report) noexcept {
  const bool finite = all_finite(command.f_H_D) && all_finite(command.t_H_D);
  report.flags = static_cast<std::uint8_t>(report.flags & ~unsigned{kCommandEnable});
  if (command.enable) report.flags |= kCommandEnable;
  report.force_un = report.torque_unm = {};
  if (!finite || !command.enable) return finite;
  for (std::size_t i = 0; i < 3; ++i) {
    report.force_un[i] = nearest<std::int32_t>(command.f_H_D[i] / kMicro);
    report.torque_unm[i] = nearest<std::int32_t>(command.t_H_D[i] / kMicro);
  }
  return true;
}

bool to_affine(const DeviceCommand& command, const AffineGains& gains,
               AffineReport& report) noexcept {
  report.k_npm = {};
  report.b_mnspm = report.kr_mnmprad = report.br_10unmsprad = {};
  bool sound = to_command(command, report.base) && all_finite(gains.K) && is_gain(gains.B) &&
               is_gain(gains.Kr) && is_gain(gains.Br);
  for (std::size_t i = 0; i < 3; ++i) sound = sound && gains.K[i] >= 0.0;
  if (!sound) report.base.force_un = report.base.torque_unm = {};
  if (!sound || !command.enable) return sound;
  double largest = 0.0;
  for (const double entry : gains.K) largest = std::max(largest, std::abs(entry));
  constexpr double kMax = std::numeric_limits<std::int16_t>::max();
  const double scale = largest > kMax ? kMax / largest : 1.0;
  for (std::size_t i = 0; i < 6; ++i) report.k_npm[i] = nearest<std::int16_t>(scale * gains.K[i]);
  for (std::size_t i = 0; i < 3; ++i) {
    report.b_mnspm[i] = nearest<std::uint16_t>(gains.B[i] / kMilli);
    report.kr_mnmprad[i] = nearest<std::uint16_t>(gains.Kr[i] / kMilli);
    report.br_10unmsprad[i] = nearest<std::uint16_t>(gains.Br[i] / kRotationalDampingStep);
  }
  return true;
}

void apply_capabilities(const Capabilities& c, DeviceProfile& profile) noexcept {
  profile.driver = DeviceDriver::kHid;
  profile.sensed_axes = count_axes(c.dof, kPositionSensedBit);
  profile.actuated_axes = count_axes(c.dof, kForceBit);
  for (std::size_t i = 0; i < 3; ++i) {
    if (c.ws_min_mm[i] < c.ws_max_mm[i]) {
      profile.workspace_lower[i] = kMilli * c.ws_min_mm[i];
      profile.workspace_upper[i] = kMilli * c.ws_max_mm[i];
    }
    if (c.rot_range_mrad[i] != 0) profile.rotation_range[i] = kMilli * c.rot_range_mrad[i];
    if (c.mass_g != 0) profile.mass[i] = kMilli * c.mass_g;
    profile.position_resolution[i] = kNano * c.pos_res_nm;
    profile.rotation_resolution[i] = kMicro * c.rot_res_urad;
  }
  profile.peak_force = kCenti * c.f_peak_cn;
  profile.peak_torque = kMilli * c.tau_peak_mnm;
  profile.continuous_force = kCenti * (c.f_cont_cn != 0 ? c.f_cont_cn : c.f_peak_cn);
  profile.continuous_torque = kMilli * (c.tau_cont_mnm != 0 ? c.tau_cont_mnm : c.tau_peak_mnm);
  if (c.k_max_npm != 0) profile.stiffness_max = c.k_max_npm;
  profile.report_rate = c.in_rate_hz;
  profile.watchdog = kMilli * c.wd_default_ms;
}

Config to_config(const SessionLimits& limits, const Capabilities& capabilities) noexcept {
  Config config;
  config.wd_ms =
      std::max(kMinWatchdog_ms, at_most(limits.watchdog / kMilli, capabilities.wd_max_ms));
  config.f_cap_cn = at_most(limits.force / kCenti, capabilities.f_peak_cn);
  config.tau_cap_mnm = at_most(limits.torque / kMilli, capabilities.tau_peak_mnm);
  config.v_cap_mmps = at_most(limits.speed / kMilli, kNoSpeedCap);
  const bool gravity = limits.gravity_compensation && (capabilities.caps & kCanGravity) != 0;
  config.grav_comp = gravity ? 1 : 0;
  return config;
}

}  // namespace hapticd::hid
