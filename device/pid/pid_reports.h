// The reports that make a device of the HID PID class push: start-up (reset, enable actuators,
// gain, an infinite constant effect for each axis, its direction, its start) and, per tick, one Set
// Constant Force report for each axis. Order of the start-up as Linux's hid-pidff; directions as
// OpenFFBoard reads them: polar, clockwise from away from the user, so that 90 degrees are +X and
// 180 degrees +Y. Forces in raw units of the magnitude. RT: set_force alone.
#pragma once

#include <cstdint>
#include <string>

#include "core/math/realtime.h"
#include "device/api/report_channel.h"
#include "device/pid/pid_layout.h"
#include "device/report_io/report_writer.h"

namespace hapticd::pid {

/// Effects, one per axis: X, then Y.
inline constexpr std::size_t kAxes = 2;
/// Times the device is asked whether an effect is loaded: as often as Linux asks.
inline constexpr int kBlockLoadTries = 60;

/// The effects as the device numbers them.
using EffectBlocks = std::array<std::uint8_t, kAxes>;

/// A report with this ID and zeros.
[[nodiscard]] HD_REALTIME OutputReport blank(const ReportForm& form) noexcept;

/// Device Control: `what` is a choice of layout.control.
[[nodiscard]] OutputReport control(const PidLayout& layout, const Choice& what) noexcept;
/// Device Gain at its largest.
[[nodiscard]] OutputReport full_gain(const PidLayout& layout) noexcept;
/// Create New Effect, a feature report: a constant force.
[[nodiscard]] OutputReport create_effect(const PidLayout& layout) noexcept;
/// Set Effect: a constant force along `axis` for ever, at full gain, with no trigger.
[[nodiscard]] OutputReport set_effect(const PidLayout& layout, std::uint8_t block,
                                      std::size_t axis) noexcept;
/// Effect Operation: start, once.
[[nodiscard]] OutputReport start_effect(const PidLayout& layout, std::uint8_t block) noexcept;
/// Set Constant Force. `magnitude` is cut to the logical range, and its fraction cut off, so
/// that no force is larger than asked for; NaN is 0.
[[nodiscard]] HD_REALTIME OutputReport set_force(const PidLayout& layout, std::uint8_t block,
                                                 double magnitude) noexcept;

/// What start() came to.
struct StartResult {
  EffectBlocks blocks{};
  std::string problem;  ///< empty: the effects run with no force; else for people
};

/// Brings the device to where only magnitudes are missing. May wait for seconds.
[[nodiscard]] StartResult start(const PidLayout& layout, const ReportChannel& channel);

/// No force, all effects stopped and the motors off, as far as the device knows how and still takes
/// it. May wait for seconds.
void stop(const PidLayout& layout, const EffectBlocks& blocks, const ReportChannel& channel);

}  // namespace hapticd::pid
