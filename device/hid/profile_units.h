// Raw units of HID profile v1 to SI and back: reports to the samples and commands of device/api,
// capabilities to a device profile. Rounded to the nearest step, saturated at the end of the range;
// what is not finite never becomes a number. Frames: device base D, handle H. SI. RT: yes where
// marked, O(1), no libm but sqrt.
#pragma once

#include <array>

#include "core/math/realtime.h"
#include "core/tick/device_sample.h"
#include "device/api/device_profile.h"
#include "device/hid/profile_v1.h"

namespace hapticd::hid {

/// The measured part of a sample: pose, velocities, grip, temperature, buttons and flags. `t_ns`,
/// `counter` and `measured_delay_s` are the driver's and stay as they are. `state`: as
/// decode_state gives it.
HD_REALTIME void to_sample(const StateReport& state, const Capabilities& capabilities,
                           DeviceSample& sample) noexcept;

/// Flags, force and torque of a report 0x02; seq, ref_seq, the grip and the other flags stay as
/// they are. A command that is not to enable has no wrench. False when a component is not finite:
/// the wrench is zero then.
HD_REALTIME bool to_command(const DeviceCommand& command, CommandReport& report) noexcept;

/// The gains of an affine command: f = f0 + K (x_ref - x) - B v, t = t0 + Kr e - Br w with e the
/// rotation from the pose to that of the report it was computed from.
struct AffineGains {
  std::array<double, 6> K{};  ///< symmetric: xx, yy, zz, xy, xz, yz, N/m
  Array3 B{};                 ///< N s/m, >= 0
  Array3 Kr{};                ///< N m/rad, >= 0
  Array3 Br{};                ///< N m s/rad, >= 0
};

/// As to_command, for report 0x03. A K beyond its range is scaled down as a whole, so that its
/// directions stay; the others saturate each. False, and all wrenches and gains zero, when a number
/// is not finite, or a diagonal entry negative.
HD_REALTIME bool to_affine(const DeviceCommand& command, const AffineGains& gains,
                           AffineReport& report) noexcept;

/// What the capabilities state goes into `profile`; what they leave open stays as it is.
void apply_capabilities(const Capabilities& capabilities, DeviceProfile& profile) noexcept;

/// Limits of a session.
struct SessionLimits {
  double watchdog = 0.02;      ///< s
  double force = kUnlimited;   ///< N
  double torque = kUnlimited;  ///< N m
  double speed = kUnlimited;   ///< m/s; unlimited: not watched by the device
  bool gravity_compensation = false;
};

/// The report that asks for these limits, rounded down, never beyond the capabilities. NaN or a
/// negative number is the strictest limit.
[[nodiscard]] Config to_config(const SessionLimits& limits,
                               const Capabilities& capabilities) noexcept;

}  // namespace hapticd::hid
