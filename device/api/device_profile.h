// What a device can do, as plain numbers: limits for the safety stage, damping and delay for the
// stiffness bound, and the plant the simulated device is built from. Axes are those of the device
// base D (x right, y up, z toward the user). SI. Defaults are those of an unspecified device. Plain
// data. RT: yes.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string_view>
#include <type_traits>

#include "core/math/vector.h"

namespace hapticd {

/// The code that talks to a device.
enum class DeviceDriver : std::uint8_t {
  kSimulated = 1,   ///< plant and arm inside the process
  kScripted = 2,    ///< poses given tick by tick
  kReplay = 3,      ///< poses of a recording
  kHid = 4,         ///< hapticd HID profile
  kSpacemouse = 5,  ///< rate input, no force
  kPid = 6,         ///< two-axis force device of the HID PID class
};

/// What the loop must know of all devices of a driver, which the driver says of itself
/// (DriverEntry).
struct DriverTraits {
  /// They have motors that can hurt: they engage only on request, and guards latch. True unless the
  /// driver denies it.
  bool can_push_a_person = true;
  /// They say neither when a sample was made nor that one was lost.
  bool has_no_clock = false;
  /// Poses of the handle come from data, and force is only recorded, never felt.
  bool follows_data = false;
};

/// No limit.
inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();
/// Longest name of a profile.
inline constexpr std::size_t kDeviceNameCapacity = 64;

/// A type of device.
struct DeviceProfile {
  std::array<char, kDeviceNameCapacity + 1> name{};  ///< ends in 0
  DeviceDriver driver = DeviceDriver::kSimulated;

  int sensed_axes = 6;    ///< of position and rotation, 0..6
  int actuated_axes = 6;  ///< 3 = force only, 6 = force and torque, 0..6

  Array3 workspace_lower{-kUnlimited, -kUnlimited, -kUnlimited};  ///< corner, m
  Array3 workspace_upper{kUnlimited, kUnlimited, kUnlimited};     ///< corner, m
  Array3 rotation_range{kUnlimited, kUnlimited, kUnlimited};  ///< about each axis, both ways, rad

  double peak_force = 0.0;                ///< along any direction, N
  double peak_torque = 0.0;               ///< about any direction, N m
  double continuous_force = kUnlimited;   ///< root mean square over thermal_window, N
  double continuous_torque = kUnlimited;  ///< root mean square over thermal_window, N m
  double thermal_window = 10.0;           ///< s
  double velocity_trip = 3.0;             ///< m/s
  double acceleration_max = 500.0;        ///< no held device exceeds it, m/s^2

  double damping = 1.0;               ///< physical damping b, N s/m
  double stiffness_max = kUnlimited;  ///< promised by the maker, N/m; unlimited = by b and delay
  double delay = 0.0;                 ///< declared, from sample to force, s
  double report_rate = 1000.0;        ///< samples per second the host sees, Hz
  double watchdog = kUnlimited;       ///< no force this long after a command, s; unlimited = none

  Array3 mass{0.15, 0.15, 0.15};                ///< apparent at the handle, kg
  Array3 inertia{1e-4, 1e-4, 1e-4};             ///< apparent at the handle, kg m^2
  Array3 rotational_damping{1e-3, 1e-3, 1e-3};  ///< N m s/rad
  Array3 coulomb_friction{};                    ///< N
  Array3 coulomb_torque{};                      ///< N m
  Array3 position_resolution{};                 ///< of the encoders, m; 0 = exact
  Array3 rotation_resolution{};                 ///< of the encoders, rad; 0 = exact
  double motor_lag = 0.0;                       ///< first-order, s

  bool affine = false;  ///< it renders DeviceCommand::spring by itself

  /// Nobody measured the damping: none is reckoned with where energy is counted, and an unknown
  /// device's where stiffness is granted.
  bool damping_guessed = false;
  bool rotational_damping_guessed = false;  ///< likewise
  /// Force told to the client that gives the poses goes to a hand: scripted devices.
  bool force_reaches_hand = false;
  /// It tells of switches that it does not have: devices of the PID class.
  bool switches_unwired = false;
};
static_assert(std::is_trivially_copyable_v<DeviceProfile>);

/// The profile's name.
[[nodiscard]] inline std::string_view device_name(const DeviceProfile& profile) noexcept {
  return {profile.name.data()};
}

/// From one report of the device to the next, ns, at least 1.
[[nodiscard]] constexpr std::int64_t report_interval_ns(const DeviceProfile& profile) noexcept {
  const double interval_ns = 1e9 / profile.report_rate;
  return interval_ns >= 1.0 && interval_ns <= 1e9 ? static_cast<std::int64_t>(interval_ns) : 1;
}

}  // namespace hapticd
