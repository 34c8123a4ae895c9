// See device_profile_target.h.
#include "tests/fuzz/device_profile_target.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>

#include "server/scene_io/message_text.h"
#include "server/scene_io/profile_loader.h"
#include "server/scene_io/sheet_translation.h"
#include "tests/fuzz/plain_line.h"

namespace hapticd::test {
namespace {

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);
}

/// False for NaN.
bool within(double value, double low, double high) { return value >= low && value <= high; }

bool each_within(const Array3& values, double low, double high) {
  return std::all_of(values.begin(), values.end(),
                     [&](double value) { return within(value, low, high); });
}

/// The smallest number above 0: of ranges that begin behind it.
constexpr double kAbove0 = std::numeric_limits<double>::denorm_min();

bool is_limit(double value, double low, double high) {
  return value == kUnlimited || within(value, low, high);
}

void check_limits(const DeviceProfile& profile) {
  require(within(profile.peak_force, 0.0, 1e3), "peak_force_n");
  require(within(profile.peak_torque, 0.0, 100.0), "peak_torque_n_m");
  require(is_limit(profile.continuous_force, 0.0, 1e3), "continuous_force_n");
  require(is_limit(profile.continuous_torque, 0.0, 100.0), "continuous_torque_n_m");
  require(within(profile.thermal_window, kAbove0, 1000.0), "thermal_window_s");
  require(within(profile.velocity_trip, kAbove0, 100.0), "velocity_trip_m_per_s");
  require(within(profile.acceleration_max, kAbove0, 1e5), "acceleration_max_m_per_s2");
  require(within(profile.damping, 0.0, 1e3), "damping_n_s_per_m");
  require(is_limit(profile.stiffness_max, kAbove0, 1e6), "stiffness_max_n_per_m");
  require(within(profile.delay, 0.0, 0.1), "delay_s");
  require(within(profile.report_rate, 10.0, 1e5), "report_rate_hz");
  require(is_limit(profile.watchdog, kAbove0, 10.0), "watchdog_s");
}

void check_plant(const DeviceProfile& profile) {
  require(each_within(profile.mass, kAbove0, 100.0), "mass_kg");
  require(each_within(profile.inertia, kAbove0, 1.0), "inertia_kg_m2");
  require(each_within(profile.rotational_damping, 0.0, 10.0), "rotational_damping");
  require(each_within(profile.coulomb_friction, 0.0, 100.0), "coulomb_friction_n");
  require(each_within(profile.coulomb_torque, 0.0, 10.0), "coulomb_friction_n_m");
  require(each_within(profile.position_resolution, 0.0, 0.01), "position_resolution_m");
  require(each_within(profile.rotation_resolution, 0.0, 1.0), "rotation_resolution_rad");
  require(within(profile.motor_lag, 0.0, 1.0), "motor_lag_s");
}

void check_room(const DeviceProfile& profile) {
  require(profile.sensed_axes >= 0 && profile.sensed_axes <= 6, "sensed_axes");
  require(profile.actuated_axes >= 0 && profile.actuated_axes <= 6, "actuated_axes");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double lower = profile.workspace_lower[axis];
    const double upper = profile.workspace_upper[axis];
    require(lower == -kUnlimited || within(lower, -10.0, 10.0), "workspace_lower_m");
    require(upper == kUnlimited || within(upper, -10.0, 10.0), "workspace_upper_m");
    require(lower < upper, "a workspace without room");
    require(is_limit(profile.rotation_range[axis], 0.0, 10.0), "rotation_range_rad");
  }
}

void check_axes(const AxisMapping& axes) {
  std::set<int> from;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    require(axes.raw_axis[axis] < 3 && from.insert(axes.raw_axis[axis]).second, "axes");
    require(std::abs(axes.sign[axis]) == 1.0, "a sign that is none");
    require(std::abs(axes.force_sign[axis]) == 1.0, "force_sign");
  }
  require(each_within(axes.position_scale, kAbove0, 1e3), "position_scale");
  require(each_within(axes.rotation_scale, kAbove0, 1e3), "rotation_scale");
  require(each_within(axes.force_scale, kAbove0, 1e3), "force_scale");
  require(within(axes.dead_zone, 0.0, 1e6), "dead_zone");
}

void check_words(const DeviceSheet& sheet) {
  const std::string_view name = device_name(sheet.profile);
  require(!name.empty() && name.size() <= kDeviceNameCapacity, "a name too long, or none");
  require(name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == name.npos, "a name");
  require(sheet.profile.driver >= DeviceDriver::kSimulated &&
              sheet.profile.driver <= DeviceDriver::kPid,
          "a driver that is none");
  require(sheet.matches.size() <= 32, "too many matches");
  for (const DeviceMatch& match : sheet.matches) {
    for (const auto& id : {match.vendor_id, match.product_id, match.usage_page, match.usage}) {
      require(!id || *id <= 65535, "an id that no device has");
    }
  }
  for (const NumberSource& source : sheet.sources) {
    require(source.values == 0 || !source.text.empty(), "a number without a source");
  }
}

void check_taken(const DeviceSheet& sheet) {
  check_words(sheet);
  check_room(sheet.profile);
  check_limits(sheet.profile);
  check_plant(sheet.profile);
  check_axes(sheet.axes);
  const bool pushes = sheet.profile.actuated_axes > 0;
  require(!pushes || !is_open(sheet, &DeviceProfile::peak_force), "a device without a peak force");
  const v1::DeviceProfile told = to_profile(sheet);
  const ProfileResult again = check_profile(told);
  require(again.loaded.has_value(), "a profile that was taken is refused as it was understood");
  require(to_profile(*again.loaded).SerializeAsString() == told.SerializeAsString(),
          "a profile is understood differently the second time");
}

}  // namespace

bool check_device_profile_bytes(std::span<const std::uint8_t> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const ProfileResult result = check_text<ProfileResult, v1::DeviceProfile>(
      text, "profile", "device profile", check_profile);
  for (const SceneProblem& problem : result.problems) {
    require(!problem.message.empty() && is_plain_line(to_text(problem)), "a problem unsaid");
  }
  require(result.loaded.has_value() != any_fault(result.problems), "refused without a reason");
  if (result.loaded) check_taken(*result.loaded);
  return result.loaded.has_value();
}

}  // namespace hapticd::test
