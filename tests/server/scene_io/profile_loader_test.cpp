// Device profiles: what is refused, with its place and remedy; what is translated to what.
#include "server/scene_io/profile_loader.h"

#include <doctest/doctest.h>

#include <cmath>

#include "device/spacemouse/spacemouse_device.h"
#include "server/scene_io/named_text.h"
#include "tests/server/scene_io/inline_text.h"
#include "tests/support/spacemouse_axes.h"

namespace hapticd::test {
namespace {

const std::string kHead = "name: \"p\" driver: DRIVER_SIMULATED\n";
const std::string kPeaks =
    "peak_force_n { value: 5 source: \"s\" }\npeak_torque_n_m { value: 0.1 source: \"s\" }\n";

std::string faults(const std::string& text) {
  const ProfileResult result = load_profile_text(text);
  CHECK(result.loaded.has_value() == !any_fault(result.problems));
  std::string lines;
  for (const SceneProblem& problem : result.problems) lines += to_text(problem) + "\n";
  return lines;
}

std::string quantity(const std::string& field, const std::string& value) {
  return kHead + kPeaks + field + " { value: " + value + " source: \"s\" }\n";
}

}  // namespace

TEST_CASE("the shipped profiles load without a doubt, with a source for every number") {
  const ProfileFolders folders{HAPTICD_SOURCE_DIR "/deploy/devices"};
  CHECK(list_names(folders).size() >= 7);
  for (const std::string& name : list_names(folders)) {
    const ProfileResult result = load_profile(name, folders);
    CAPTURE(name);
    REQUIRE(result.loaded.has_value());
    CHECK(result.problems.empty());
    CHECK(device_name(result.loaded->profile) == name);
    if (result.loaded->profile.driver != DeviceDriver::kSimulated) continue;
    CHECK(result.loaded->profile.peak_force == 22.0);
    CHECK(result.loaded->profile.peak_torque == 0.515);
  }
  const DeviceProfile premium = load_profile("premium_3_0_6dof", folders).loaded->profile;
  CHECK(premium.continuous_force == 3.0);
  CHECK(premium.mass == Array3{0.159, 0.159, 0.159});
  CHECK(premium.coulomb_friction == Array3{0.2, 0.2, 0.2});
  CHECK(premium.position_resolution == Array3{2e-5, 2e-5, 2e-5});
  CHECK(premium.workspace_upper == Array3{0.419, 0.292, 0.203});
}

TEST_CASE("what a profile leaves out has the default of its comment") {
  const ProfileResult result = load_profile_text(kHead + kPeaks);
  REQUIRE(result.loaded.has_value());
  const DeviceProfile& p = result.loaded->profile;
  CHECK(p.sensed_axes == 6);
  CHECK(p.actuated_axes == 6);
  CHECK(p.workspace_lower[0] == -kUnlimited);
  CHECK(p.workspace_upper[2] == kUnlimited);
  CHECK(p.continuous_force == kUnlimited);
  CHECK(p.continuous_torque == kUnlimited);
  CHECK(p.thermal_window == 10.0);
  CHECK(p.velocity_trip == 3.0);
  CHECK(p.acceleration_max == 500.0);
  CHECK(p.damping == 1.0);
  CHECK(p.stiffness_max == kUnlimited);
  CHECK(p.delay == 0.0);
  CHECK(p.report_rate == 1000.0);
  CHECK(p.watchdog == kUnlimited);
  CHECK(p.mass == Array3{0.15, 0.15, 0.15});
  CHECK(p.inertia == Array3{1e-4, 1e-4, 1e-4});
  CHECK(p.rotational_damping == Array3{1e-3, 1e-3, 1e-3});
  CHECK(p.coulomb_friction == Array3{});
  CHECK(p.motor_lag == 0.0);
}

TEST_CASE("one number stands for all axes, three for one each") {
  CHECK(load_profile_text(quantity("mass_kg", "0.3")).loaded->profile.mass ==
        Array3{0.3, 0.3, 0.3});
  CHECK(load_profile_text(quantity("mass_kg", "[0.1, 0.2, 0.3]")).loaded->profile.mass ==
        Array3{0.1, 0.2, 0.3});
}

TEST_CASE("profiles that break what the comments of device_profile.proto promise are refused") {
  const std::pair<std::string, std::string> cases[] = {
      {"driver: DRIVER_HID " + kPeaks, "name"},
      {"name: \"X\" driver: DRIVER_HID " + kPeaks, "not a name for a profile"},
      {"name: \"p\" " + kPeaks, "no driver"},
      {kHead, "peak_force_n"},
      {kHead + "peak_force_n { value: 5 source: \"s\" }", "peak_torque_n_m"},
      {kHead + "peak_force_n { value: 5 }", "without a source"},
      {quantity("damping_n_s_per_m", "[1, 2, 3]"), "3 numbers"},
      {quantity("mass_kg", "[1, 2]"), "2 numbers"},
      {quantity("workspace_lower_m", "1"), "1 numbers"},
      {quantity("mass_kg", "0"), "0 is not in (0, 100] kg"},
      {quantity("mass_kg", "nan"), "(0, 100] kg"},
      {quantity("delay_s", "0.2"), "[0, 0.1] s"},
      {quantity("report_rate_hz", "1"), "[10, 1e5] Hz"},
      {quantity("actuated_axes", "2.5"), "whole"},
      {kHead + kPeaks + "axis_map { axes: [AXIS_POSITIVE_X, AXIS_NEGATIVE_X, AXIS_POSITIVE_Z] }",
       "three different axes"},
      {kHead + kPeaks + "axis_map { axes: [AXIS_POSITIVE_X, AXIS_NEGATIVE_Y] }",
       "three different axes"},
      {kHead + kPeaks + "axis_map { axes: [AXIS_POSITIVE_X, 9, AXIS_NEGATIVE_Y] }", "9"},
      {kHead + kPeaks + "axis_map { position_scale { value: 0 source: \"s\" } }", "(0, 1e3]"},
      {kHead + kPeaks + "matches { vendor_id: 65536 }", "[0, 65535]"},
      {quantity("workspace_lower_m", "[0, 0, 0]") +
           "workspace_upper_m { value: [1, 0, 1] source: \"s\" }",
       "not above"},
      {"name: \"p\" color: 3", "color"},
  };
  for (const auto& each : cases) {
    const std::string text = each.first;
    const std::string found = faults(text);
    CAPTURE(text);
    CAPTURE(found);
    CHECK(found.find(each.second) != std::string::npos);
  }
}

TEST_CASE("a fault in a profile names its line; axes that are a permutation are taken") {
  const std::string text = faults(quantity("delay_s", "-1"));
  CHECK(text.find("inline:4:11: error: delay_s.value[0]") != std::string::npos);
  CHECK(faults(kHead + kPeaks +
               "axis_map { axes: [AXIS_NEGATIVE_Z, AXIS_POSITIVE_X, AXIS_NEGATIVE_Y] }") == "");
}

TEST_CASE("a device that only reads positions needs no peak force") {
  const ProfileResult result = load_profile_text(
      "name: \"mouse\" driver: DRIVER_SPACEMOUSE actuated_axes { value: 0 source: \"s\" }");
  REQUIRE(result.loaded.has_value());
  CHECK(result.loaded->profile.driver == DeviceDriver::kSpacemouse);
  CHECK(result.loaded->profile.peak_force == 0.0);
}

TEST_CASE("an axis map becomes the mapping of the drivers, and none leaves readings as they are") {
  const ProfileResult result = load_profile_text(
      kHead + kPeaks +
      "axis_map { axes: [AXIS_NEGATIVE_Z, AXIS_POSITIVE_X, AXIS_NEGATIVE_Y]"
      " position_scale { value: [1, 2, 3] source: \"s\" } rotation_scale { value: 4 source: \"s\" }"
      " force_scale { value: 0.5 source: \"s\" } force_sign { value: [1, -1, 1] source: \"s\" }"
      " dead_zone { value: 7 source: \"s\" } }");
  REQUIRE(result.loaded.has_value());
  const AxisMapping& axes = result.loaded->axes;
  CHECK(axes.raw_axis == std::array<std::uint8_t, 3>{2, 0, 1});
  CHECK(axes.sign == Array3{-1.0, 1.0, -1.0});
  CHECK(axes.position_scale == Array3{1.0, 2.0, 3.0});
  CHECK(axes.rotation_scale == Array3{4.0, 4.0, 4.0});
  CHECK(axes.force_scale == Array3{0.5, 0.5, 0.5});
  CHECK(axes.force_sign == Array3{1.0, -1.0, 1.0});
  CHECK(axes.dead_zone == 7.0);
  const AxisMapping none = load_profile_text(kHead + kPeaks).loaded->axes;
  CHECK(none.raw_axis == std::array<std::uint8_t, 3>{0, 1, 2});
  CHECK(none.sign == Array3{1.0, 1.0, 1.0});
  CHECK(none.force_scale == Array3{1.0, 1.0, 1.0});
  CHECK(none.dead_zone == 0.0);
}

TEST_CASE("a force sign that is no sign is refused") {
  CHECK(faults(kHead + kPeaks + "axis_map { force_sign { value: [1, 0.5, 1] source: \"s\" } }")
            .find("0.5 is not a sign") != std::string::npos);
}

TEST_CASE("the profile of the SpaceMouse family names the devices the driver knows, at its axes") {
  const ProfileFolders folders{HAPTICD_SOURCE_DIR "/deploy/devices"};
  const DeviceSheet mouse = *load_profile("spacemouse", folders).loaded;
  int known = 0;
  for (std::uint32_t vendor : {0x046DU, 0x256FU}) {
    for (std::uint32_t product = 0; product < 0x10000; ++product) {
      const auto vendor_id = static_cast<std::uint16_t>(vendor);
      const auto product_id = static_cast<std::uint16_t>(product);
      // A receiver's number says nothing of what is behind it.
      known += spacemouse::is_spacemouse(vendor_id, product_id) &&
                       !spacemouse::is_receiver(vendor_id, product_id)
                   ? 1
                   : 0;
    }
  }
  int by_number = 0;
  int by_descriptor = 0;
  for (const DeviceMatch& match : mouse.matches) {
    if (!match.product_id.has_value()) {
      ++by_descriptor;
      continue;
    }
    ++by_number;
    CAPTURE(match.product_id.value());
    CHECK(spacemouse::is_spacemouse(static_cast<std::uint16_t>(match.vendor_id.value()),
                                    static_cast<std::uint16_t>(match.product_id.value())));
  }
  CHECK(by_number == known);
  CHECK(by_descriptor == 1);
  const AxisMapping family = test::family_axes(1.0, 1.0);
  CHECK(mouse.axes.raw_axis == family.raw_axis);
  CHECK(mouse.axes.sign == family.sign);
  CHECK(mouse.profile.actuated_axes == 0);
}

TEST_CASE("the profiles of devices without a watchdog give no more than 1 N") {
  const ProfileFolders folders{HAPTICD_SOURCE_DIR "/deploy/devices"};
  for (const char* name : {"openffboard", "vpforce_rhino"}) {
    CAPTURE(name);
    const DeviceSheet stick = *load_profile(name, folders).loaded;
    CHECK(stick.profile.driver == DeviceDriver::kPid);
    CHECK(stick.profile.watchdog == kUnlimited);
    CHECK(stick.profile.peak_force <= 1.0);
    CHECK(stick.profile.actuated_axes == 2);
    // Raw z, which such a device has not, is up.
    CHECK(stick.axes.raw_axis == std::array<std::uint8_t, 3>{0, 2, 1});
  }
}

}  // namespace hapticd::test
