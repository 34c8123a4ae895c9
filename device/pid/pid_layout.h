// Which reports and bits of a force device of the HID PID class (Device Class Definition for
// Physical Interface Devices 1.0) carry what the driver needs: two axes in, one infinite constant
// effect per axis out. Found by usage, so that report IDs, sizes and ranges may be any. Bits count
// from the first byte of a report, its ID included. Looking for them: offline. What is found is
// plain data; put and get: RT.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>

#include "core/math/realtime.h"
#include "device/pid/field_descriptor.h"

namespace hapticd::pid {

/// Where a number is, and its logical range.
struct BitField {
  std::uint16_t bit = 0;
  std::uint8_t bits = 0;  ///< 0: the device has none
  std::int64_t minimum = 0;
  std::int64_t maximum = 0;

  [[nodiscard]] bool exists() const noexcept { return bits != 0; }
};

/// A number that means one thing, and where it is: an entry of an array, or a flag.
struct Choice {
  BitField field;
  std::int64_t value = 0;
};

/// A report, its ID included.
struct ReportForm {
  std::uint8_t id = 0;
  std::uint8_t bytes = 0;  ///< 0: the device has none
};

/// Buttons looked at.
inline constexpr std::size_t kMaxButtons = 16;

/// All that is used of a device. What may be missing says so.
struct PidLayout {
  struct Input {
    ReportForm report;
    BitField x, y;
    std::array<BitField, kMaxButtons> button{};  ///< may be missing
  } input;
  struct State {
    ReportForm report;                     ///< may be missing
    BitField paused, actuators, power;     ///< may be missing
    BitField safety_switch, force_switch;  ///< may be missing
  } state;
  struct SetConstant {
    ReportForm report;
    BitField block, magnitude;  ///< the magnitude has both signs
  } constant;
  struct SetEffect {
    ReportForm report;
    BitField block;
    Choice constant;                          ///< may be missing
    BitField duration, gain, trigger_button;  ///< may be missing
    Choice direction_enable;                  ///< or else axis_enable
    BitField direction;                       ///< polar, its range a full turn
    std::array<Choice, 2> axis_enable{};      ///< where there is no direction
  } effect;
  struct Operation {
    ReportForm report;
    BitField block;
    Choice start;
    BitField loops;  ///< may be missing
  } operation;
  struct Control {
    ReportForm report;
    Choice enable;
    Choice reset, stop_all, disable;  ///< may be missing
  } control;
  struct Gain {
    ReportForm report;  ///< may be missing
    BitField gain;
  } gain;
  struct Create {
    ReportForm report;  ///< feature
    Choice constant;
  } create;
  struct BlockLoad {
    ReportForm report;  ///< feature
    BitField block;
    Choice success;
  } load;
};
static_assert(std::is_trivially_copyable_v<PidLayout>);

/// A layout, or what the device lacks for one.
struct LayoutResult {
  PidLayout layout;
  std::string lack;  ///< empty: nothing; else for people, such as "the X axis"
};

/// Looks through a report descriptor. Reports longer than kMaxReport of report_channel.h are
/// not used, nor are devices without report IDs. Of several devices in one descriptor the stick or
/// game pad that pushes is meant: mice, keyboards and what a maker adds have axes of their own.
[[nodiscard]] LayoutResult find_layout(std::span<const std::uint8_t> descriptor);

/// Writes the low bits of `value` into the report. The field lies within it.
HD_REALTIME void put(const BitField& field, std::int64_t value,
                     std::span<std::uint8_t> report) noexcept;
/// The number in the report, with sign where its range has one; 0 where the report is too short.
[[nodiscard]] HD_REALTIME std::int64_t get(const BitField& field,
                                           std::span<const std::uint8_t> report) noexcept;

}  // namespace hapticd::pid
