// Bytes of HID profile v1 to structs and back. Pure: no device, no clock. Whatever the bytes are,
// the result is a struct or the name of what is wrong with them. Reserved bytes are written as zero
// and not looked at. Raw units: profile_v1.h. RT: yes, O(1), no heap.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/math/realtime.h"
#include "device/hid/profile_v1.h"

namespace hapticd::hid {

/// What a decoder found.
enum class Decoded : std::uint8_t {
  kOk,
  kWrongLength,   ///< not the length of this report
  kWrongId,       ///< byte 0 is another report's
  kWrongMagic,    ///< not a device of this profile
  kWrongVersion,  ///< of another major version
  kOutOfRange,    ///< a field has a value that the profile excludes
};

/// For messages: "wrong length" and so on.
[[nodiscard]] std::string_view name_of(Decoded decoded) noexcept;

/// Largest deviation from 1 of the squared norm of an orientation. Q30 rounds to 1e-9; wider takes
/// in devices that do not normalise, and a wrong layout that looks like one.
inline constexpr double kOrientationTolerance = 1e-3;

/// Input 0x01. `state` is untouched unless kOk; kOutOfRange: the quaternion is not a unit one.
[[nodiscard]] HD_REALTIME Decoded decode_state(std::span<const std::uint8_t> bytes,
                                               StateReport& state) noexcept;
/// Feature 0x10. Untouched unless kOk; kOutOfRange: see section 5 of PROFILE.md.
[[nodiscard]] Decoded decode_capabilities(std::span<const std::uint8_t> bytes,
                                          Capabilities& capabilities) noexcept;
/// Feature 0x11, any values. Untouched unless kOk.
[[nodiscard]] Decoded decode_config(std::span<const std::uint8_t> bytes, Config& config) noexcept;
/// Feature 0x12. Untouched unless kOk; kOutOfRange: an unknown op or state, or more than 100 %.
[[nodiscard]] Decoded decode_calibration(std::span<const std::uint8_t> bytes,
                                         Calibration& calibration) noexcept;

/// The bytes of each report, ID first.
[[nodiscard]] HD_REALTIME std::array<std::uint8_t, kStateBytes> encode(
    const StateReport& state) noexcept;
[[nodiscard]] HD_REALTIME std::array<std::uint8_t, kCommandBytes> encode(
    const CommandReport& command) noexcept;
[[nodiscard]] HD_REALTIME std::array<std::uint8_t, kAffineBytes> encode(
    const AffineReport& affine) noexcept;
[[nodiscard]] std::array<std::uint8_t, kCapabilitiesBytes> encode(
    const Capabilities& capabilities) noexcept;
[[nodiscard]] std::array<std::uint8_t, kConfigBytes> encode(const Config& config) noexcept;
[[nodiscard]] std::array<std::uint8_t, kCalibrationBytes> encode(
    const Calibration& calibration) noexcept;

}  // namespace hapticd::hid
