// A device's profile with what is known of each number: whether anybody stated it, who, and whether
// it is a guess. A driver fills in what the device says of itself and lowers limits; the rest stays
// as the profile's author wrote it. Not RT.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "device/api/axis_mapping.h"
#include "device/api/device_profile.h"

namespace hapticd {

/// A number of a sheet, by its place.
using SheetNumber =
    std::variant<double DeviceProfile::*, int DeviceProfile::*, Array3 DeviceProfile::*,
                 double AxisMapping::*, Array3 AxisMapping::*>;

struct SheetRow {
  SheetNumber number;
  std::string_view name;  ///< of its Quantity in DeviceProfile of device_profile.proto
};

/// Every number that has a source.
inline constexpr std::array kSheetRows{
    SheetRow{&DeviceProfile::sensed_axes, "sensed_axes"},
    SheetRow{&DeviceProfile::actuated_axes, "actuated_axes"},
    SheetRow{&DeviceProfile::workspace_lower, "workspace_lower_m"},
    SheetRow{&DeviceProfile::workspace_upper, "workspace_upper_m"},
    SheetRow{&DeviceProfile::rotation_range, "rotation_range_rad"},
    SheetRow{&DeviceProfile::peak_force, "peak_force_n"},
    SheetRow{&DeviceProfile::peak_torque, "peak_torque_n_m"},
    SheetRow{&DeviceProfile::continuous_force, "continuous_force_n"},
    SheetRow{&DeviceProfile::continuous_torque, "continuous_torque_n_m"},
    SheetRow{&DeviceProfile::thermal_window, "thermal_window_s"},
    SheetRow{&DeviceProfile::velocity_trip, "velocity_trip_m_per_s"},
    SheetRow{&DeviceProfile::acceleration_max, "acceleration_max_m_per_s2"},
    SheetRow{&DeviceProfile::damping, "damping_n_s_per_m"},
    SheetRow{&DeviceProfile::stiffness_max, "stiffness_max_n_per_m"},
    SheetRow{&DeviceProfile::delay, "delay_s"},
    SheetRow{&DeviceProfile::report_rate, "report_rate_hz"},
    SheetRow{&DeviceProfile::watchdog, "watchdog_s"},
    SheetRow{&DeviceProfile::mass, "mass_kg"},
    SheetRow{&DeviceProfile::inertia, "inertia_kg_m2"},
    SheetRow{&DeviceProfile::rotational_damping, "rotational_damping_n_m_s_per_rad"},
    SheetRow{&DeviceProfile::coulomb_friction, "coulomb_friction_n"},
    SheetRow{&DeviceProfile::coulomb_torque, "coulomb_friction_n_m"},
    SheetRow{&DeviceProfile::position_resolution, "position_resolution_m"},
    SheetRow{&DeviceProfile::rotation_resolution, "rotation_resolution_rad"},
    SheetRow{&DeviceProfile::motor_lag, "motor_lag_s"},
    SheetRow{&AxisMapping::position_scale, "axis_map.position_scale"},
    SheetRow{&AxisMapping::rotation_scale, "axis_map.rotation_scale"},
    SheetRow{&AxisMapping::force_sign, "axis_map.force_sign"},
    SheetRow{&AxisMapping::force_scale, "axis_map.force_scale"},
    SheetRow{&AxisMapping::dead_zone, "axis_map.dead_zone"},
};

/// Where a number comes from.
struct NumberSource {
  std::size_t values = 0;  ///< stated: 1, or 3 of one for each axis; 0: open, the default holds
  std::string text;        ///< data sheet, measurement, or why this guess
  bool guess = false;      ///< nobody measured it
};

/// Devices that a profile is for; all that is given must fit.
struct DeviceMatch {
  std::optional<std::uint32_t> vendor_id;
  std::optional<std::uint32_t> product_id;
  std::optional<std::uint32_t> usage_page;  ///< of the first collection of the report descriptor
  std::optional<std::uint32_t> usage;       ///< likewise
  std::optional<std::string> serial;
};

/// The defaults of a profile, of which nobody has measured anything.
[[nodiscard]] constexpr DeviceProfile unmeasured_profile() {
  DeviceProfile profile;
  profile.damping_guessed = profile.rotational_damping_guessed = true;
  return profile;
}

struct DeviceSheet {
  DeviceProfile profile = unmeasured_profile();  ///< defaults where a number is open
  AxisMapping axes;                              ///< likewise; for drivers of raw frames
  bool axes_stated = false;          ///< which raw axes become x, y, z of D; else the default holds
  std::string description;           ///< maker and model, for people; may be empty
  std::vector<DeviceMatch> matches;  ///< any of them may fit; none: the profile goes by its name
  std::array<NumberSource, kSheetRows.size()> sources;  ///< of kSheetRows
};

/// The source of a number.
[[nodiscard]] const NumberSource& source_of(const DeviceSheet& sheet, SheetNumber number);

/// Nobody has stated the number.
[[nodiscard]] bool is_open(const DeviceSheet& sheet, SheetNumber number);

/// The numbers that are stated: none, 1, or 3.
[[nodiscard]] std::vector<double> stated_values(const DeviceSheet& sheet, SheetNumber number);

/// States a number, whatever was stated before: `source.values` of `values`. One value of a number
/// that has three holds for each axis. No values: as leave_open.
void state_number(DeviceSheet& sheet, SheetNumber number, const std::vector<double>& values,
                  NumberSource source);

/// Source of a number that the device states of itself.
inline constexpr const char* kStated = "the device's capabilities";

/// States a number, from kStated, where it is open.
void fill(DeviceSheet& sheet, SheetNumber number, std::initializer_list<double> values);

/// The lower one of the limit and `most`; infinite (kUnlimited): there is none. 0 is a limit: a
/// device that states a peak force of 0 gives none.
void limit(DeviceSheet& sheet, double DeviceProfile::*number, double most,
           const char* source = kStated);

/// Forgets what was stated of a number: the default holds.
void leave_open(DeviceSheet& sheet, SheetNumber number);

}  // namespace hapticd
