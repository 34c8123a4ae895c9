// What goes between a haptic device and the loop once per tick: the sample it measured and the
// command it is given. Frames: D device base (x right, y up, z toward the user), H the handle, in
// monogram notation. SI, times on the clock the loop runs by. Plain data: both cross threads. RT:
// yes.
#pragma once

#include <cstdint>
#include <limits>
#include <type_traits>

#include "core/math/spring.h"
#include "core/math/vector.h"

namespace hapticd {

/// Bits of DeviceSample::flags.
inline constexpr std::uint16_t kDeviceAttached = 1U << 0U;
inline constexpr std::uint16_t kDeviceCalibrated = 1U << 1U;
/// Its motors are on.
inline constexpr std::uint16_t kDeviceEnabled = 1U << 2U;
/// The dead-man switch is held.
inline constexpr std::uint16_t kDeviceDeadManHeld = 1U << 3U;
inline constexpr std::uint16_t kDeviceEmergencyStop = 1U << 4U;
/// The device's own watchdog cut the force: no command came in time.
inline constexpr std::uint16_t kDeviceWatchdogFired = 1U << 5U;
/// The last command was beyond what the device can give.
inline constexpr std::uint16_t kDeviceSaturated = 1U << 6U;
inline constexpr std::uint16_t kDeviceReportsFault = 1U << 7U;
/// It has a dead-man switch, which is not held.
inline constexpr std::uint16_t kDeviceDeadManOpen = 1U << 8U;

/// One measurement. Where the device measures no velocities they are the difference of successive
/// samples.
struct DeviceSample {
  std::int64_t t_ns = 0;      ///< instant of the measurement, never decreasing
  std::uint64_t counter = 0;  ///< grows by at least 1 with every fresh sample; a gap is a lost one
  Array3 p_DH{};              ///< handle position in D, m
  Array4 q_DH{1.0, 0.0, 0.0, 0.0};  ///< handle orientation (w, x, y, z), unit to 1e-6
  Array3 v_DH_D{};                  ///< velocity of the handle, m/s
  Array3 w_DH_D{};                  ///< angular velocity of the handle, rad/s
  float grip_m = std::numeric_limits<float>::quiet_NaN();  ///< opening; NaN = none
  float temperature_deg_c =
      std::numeric_limits<float>::quiet_NaN();  ///< hottest winding; NaN = none
  /// Delay from sample to force as the driver measured it from the device's echo of commands, s;
  /// NaN = no echo, or not yet: the declared one counts.
  double measured_delay_s = std::numeric_limits<double>::quiet_NaN();
  std::uint32_t buttons = 0;  ///< bit i = button i
  std::uint16_t flags = 0;    ///< kDevice... bits
  bool has_velocity = false;  ///< the device measures velocities itself
};
static_assert(std::is_trivially_copyable_v<DeviceSample>);

/// One command. The device shortens what is beyond its peak along its direction.
struct DeviceCommand {
  Array3 f_H_D{};  ///< force the device puts on the hand, in D, N
  Array3 t_H_D{};  ///< torque about H, in D, N m
  /// No longer valid from here on: zero force if nothing newer came.
  std::int64_t expires_ns = std::numeric_limits<std::int64_t>::max();
  std::uint64_t sample_counter = 0;  ///< of the sample the wrench was computed from
  /// About the pose of that sample, for devices whose profile is `affine`; others leave it out.
  DeviceSpring spring{};
  bool enable = false;        ///< motors on; off means zero force
  bool clear_faults = false;  ///< forget what was latched: the user's decision; means zero force
};
static_assert(std::is_trivially_copyable_v<DeviceCommand>);

}  // namespace hapticd
