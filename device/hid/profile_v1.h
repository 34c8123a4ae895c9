// The reports of HID profile v1 as plain structs, in the raw units of the wire; PROFILE.md is the
// specification. Bytes to structs: profile_codec.h; raw units to SI: profile_units.h. Units that
// are not SI are in the names (un = uN, unm = uN m, npm = N/m). Frames: device base D, handle H.
// Plain data. RT: yes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace hapticd::hid {

/// Usage page and usage of the top-level collection: how a device is found.
inline constexpr std::uint16_t kUsagePage = 0xFF48;
inline constexpr std::uint16_t kUsage = 0x0001;
/// The bytes "HAP1", little-endian.
inline constexpr std::uint32_t kMagic = 0x31504148;
/// The major version this code speaks. Any minor one is understood.
inline constexpr std::uint8_t kVersionMajor = 1;

/// Report IDs.
inline constexpr std::uint8_t kStateId = 0x01;
inline constexpr std::uint8_t kCommandId = 0x02;
inline constexpr std::uint8_t kAffineId = 0x03;
inline constexpr std::uint8_t kCapabilitiesId = 0x10;
inline constexpr std::uint8_t kConfigId = 0x11;
inline constexpr std::uint8_t kCalibrationId = 0x12;

/// Bytes of each report, the ID included.
inline constexpr std::size_t kStateBytes = 64;
inline constexpr std::size_t kCommandBytes = 32;
inline constexpr std::size_t kAffineBytes = 64;
inline constexpr std::size_t kCapabilitiesBytes = 64;
inline constexpr std::size_t kConfigBytes = 16;
inline constexpr std::size_t kCalibrationBytes = 8;

/// Bits of StateReport::status.
inline constexpr std::uint8_t kStatusEnabled = 1U << 0U;
inline constexpr std::uint8_t kStatusCalibrated = 1U << 1U;
inline constexpr std::uint8_t kStatusActive = 1U << 2U;
inline constexpr std::uint8_t kStatusDeadManHeld = 1U << 3U;
inline constexpr std::uint8_t kStatusWatchdog = 1U << 4U;
inline constexpr std::uint8_t kStatusSaturated = 1U << 5U;
inline constexpr std::uint8_t kStatusEmergencyStop = 1U << 6U;
inline constexpr std::uint8_t kStatusFault = 1U << 7U;

/// Bits of StateReport::fault.
inline constexpr std::uint16_t kFaultOverTemperature = 1U << 0U;
inline constexpr std::uint16_t kFaultOverCurrent = 1U << 1U;
inline constexpr std::uint16_t kFaultUnderVoltage = 1U << 2U;
inline constexpr std::uint16_t kFaultEncoder = 1U << 3U;
inline constexpr std::uint16_t kFaultRange = 1U << 4U;
inline constexpr std::uint16_t kFaultOverSpeed = 1U << 5U;
inline constexpr std::uint16_t kFaultUsb = 1U << 6U;
inline constexpr std::uint16_t kFaultInternal = 1U << 7U;
inline constexpr std::uint16_t kFaultBadCommand = 1U << 8U;

/// Bits of CommandReport::flags.
inline constexpr std::uint8_t kCommandEnable = 1U << 0U;
inline constexpr std::uint8_t kCommandClearFault = 1U << 1U;
inline constexpr std::uint8_t kCommandBrake = 1U << 2U;
inline constexpr std::uint8_t kCommandGrip = 1U << 3U;

/// Bits of Capabilities::caps.
inline constexpr std::uint32_t kCanAffine = 1U << 0U;
inline constexpr std::uint32_t kNeedsCalibration = 1U << 1U;
inline constexpr std::uint32_t kHasDeadMan = 1U << 2U;
inline constexpr std::uint32_t kHasBrake = 1U << 3U;
inline constexpr std::uint32_t kCanGravity = 1U << 4U;
inline constexpr std::uint32_t kHasTemperature = 1U << 5U;
inline constexpr std::uint32_t kHasVelocity = 1U << 6U;

/// Bits of Capabilities::dof: three axes each from the first one on.
inline constexpr unsigned kPositionSensedBit = 0;
inline constexpr unsigned kRotationSensedBit = 3;
inline constexpr unsigned kForceBit = 6;
inline constexpr unsigned kTorqueBit = 9;
inline constexpr std::uint16_t kGripSensed = 1U << 12U;
inline constexpr std::uint16_t kGripForce = 1U << 13U;

/// Buttons that a state has room for.
inline constexpr std::uint8_t kMaxButtons = 16;
/// Shortest and longest watchdog a device may have, ms.
inline constexpr std::uint16_t kMinWatchdog_ms = 2;
inline constexpr std::uint16_t kMaxWatchdog_ms = 100;
/// StateReport::cmd_age: no command yet, or one older than can be said.
inline constexpr std::uint16_t kOldestCommand = 0xFFFF;
/// StateReport::temp_deg_c: not known.
inline constexpr std::uint8_t kUnknownTemperature = 0xFF;
/// Config::v_cap_mmps: no speed is too high.
inline constexpr std::uint16_t kNoSpeedCap = 0xFFFF;
/// 1.0 in Q30.
inline constexpr std::int32_t kOneQ30 = 1 << 30;

/// Input 0x01: one sample.
struct StateReport {
  std::uint8_t status = 0;
  std::uint16_t seq = 0;   ///< +1 per sample, wraps
  std::uint32_t t_us = 0;  ///< device clock at the sample, wraps
  std::array<std::int32_t, 3> pos_nm{};
  std::array<std::int32_t, 4> quat_q30{kOneQ30, 0, 0, 0};  ///< w, x, y, z
  std::array<std::int16_t, 3> vel_100ums{};                ///< 0.1 mm/s
  std::array<std::int16_t, 3> avel_mradps{};
  std::int16_t grip_10um = 0;
  std::int16_t grip_vel_mmps = 0;
  std::uint16_t buttons = 0;
  std::uint16_t cmd_seq = 0;               ///< of the last command accepted
  std::uint16_t cmd_age = kOldestCommand;  ///< its age at t_us, 10 us
  std::uint16_t fault = 0;
  std::uint8_t temp_deg_c = kUnknownTemperature;
  std::uint8_t load = 0;  ///< 255 = limit
  bool operator==(const StateReport&) const = default;
};

/// Output 0x02: the wrench until the next one.
struct CommandReport {
  std::uint8_t flags = 0;
  std::uint16_t seq = 0;
  std::array<std::int32_t, 3> force_un{};
  std::array<std::int32_t, 3> torque_unm{};
  std::int16_t grip_mn = 0;
  std::uint16_t ref_seq = 0;  ///< of the state it was computed from
  bool operator==(const CommandReport&) const = default;
};

/// Output 0x03: f = f0 + K (x_ref - x) - B v, and the same about the axes, closed by the device.
struct AffineReport {
  CommandReport base;                            ///< f0, t0
  std::array<std::int16_t, 6> k_npm{};           ///< xx, yy, zz, xy, xz, yz
  std::array<std::uint16_t, 3> b_mnspm{};        ///< mN s/m
  std::array<std::uint16_t, 3> kr_mnmprad{};     ///< mN m/rad
  std::array<std::uint16_t, 3> br_10unmsprad{};  ///< 10 uN m s/rad
  bool operator==(const AffineReport&) const = default;
};

/// Feature 0x10: what the device is.
struct Capabilities {
  std::uint8_t ver_major = kVersionMajor;
  std::uint8_t ver_minor = 0;
  std::uint8_t n_buttons = 0;
  std::uint32_t caps = 0;
  std::uint16_t dof = 0;
  std::uint16_t in_rate_hz = 0;
  std::uint16_t servo_rate_hz = 0;
  std::uint16_t wd_default_ms = 0;
  std::uint16_t wd_max_ms = 0;
  std::uint16_t f_cont_cn = 0;  ///< 0.01 N
  std::uint16_t f_peak_cn = 0;  ///< 0.01 N
  std::uint16_t tau_cont_mnm = 0;
  std::uint16_t tau_peak_mnm = 0;
  std::uint16_t k_max_npm = 0;  ///< 0 = not stated
  std::array<std::int16_t, 3> ws_min_mm{};
  std::array<std::int16_t, 3> ws_max_mm{};
  std::array<std::uint16_t, 3> rot_range_mrad{};  ///< both ways; 0 = not limited
  std::uint32_t pos_res_nm = 0;
  std::uint32_t rot_res_urad = 0;
  std::uint16_t mass_g = 0;      ///< 0 = not stated
  std::uint16_t grip_range = 0;  ///< 10 um
  bool operator==(const Capabilities&) const = default;
};

/// Feature 0x11: limits of this session.
struct Config {
  std::uint16_t wd_ms = 0;
  std::uint16_t f_cap_cn = 0;
  std::uint16_t tau_cap_mnm = 0;
  std::uint16_t v_cap_mmps = kNoSpeedCap;
  std::uint8_t grav_comp = 0;
  bool operator==(const Config&) const = default;
};

/// What to do, and how far it is.
enum class CalibrationOp : std::uint8_t {
  kNone = 0,
  kStart = 1,
  kZeroHere = 2,
  kAbort = 3,
  kStore = 4,
};
enum class CalibrationState : std::uint8_t { kNone = 0, kRunning = 1, kOk = 2, kFailed = 3 };

/// Feature 0x12.
struct Calibration {
  CalibrationOp op = CalibrationOp::kNone;
  CalibrationState state = CalibrationState::kNone;
  std::uint8_t progress = 0;    ///< per cent
  std::uint16_t axis_mask = 0;  ///< bits 0-2 position, 3-5 rotation, 6 grip
  bool operator==(const Calibration&) const = default;
};

}  // namespace hapticd::hid
