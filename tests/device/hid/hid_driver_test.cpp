// What becomes of a device's own word and a profile. Truth: the numbers put in.
#include "device/hid/hid_driver.h"

#include <doctest/doctest.h>

#include "server/scene_io/profile_loader.h"
#include "server/scene_io/sheet_translation.h"

namespace hapticd::test {
namespace {

DeviceSheet installed() {
  ProfileResult result = load_profile(HAPTICD_SOURCE_DIR "/deploy/devices/hid_v1.textproto", {});
  REQUIRE(result.loaded.has_value());
  return *result.loaded;
}

/// Three axes of force, 9 N, 3000 N/m, a workspace.
hid::Capabilities stated() {
  hid::Capabilities capabilities;
  capabilities.dof = 0x01FF;
  capabilities.in_rate_hz = 1000;
  capabilities.wd_default_ms = 20;
  capabilities.wd_max_ms = 100;
  capabilities.f_cont_cn = 300;
  capabilities.f_peak_cn = 900;
  capabilities.k_max_npm = 3000;
  capabilities.ws_min_mm = {-100, -50, -60};
  capabilities.ws_max_mm = {100, 50, 60};
  return capabilities;
}

HidrawNode node() {
  HidrawNode made;
  made.path = "/dev/hidraw7";
  made.serial = "S1";
  made.product = "Pen";
  return made;
}

/// The numbers of a sheet that makes a profile.
DeviceProfile numbers(const DeviceSheet& sheet) {
  const ProfileResult result = check_profile(to_profile(sheet));
  for (const SceneProblem& problem : result.problems) FAIL_CHECK(to_text(problem));
  return sheet.profile;
}

}  // namespace

TEST_CASE("what a device states fills in what the profile of every HID device leaves open") {
  const DeviceProfile profile = numbers(hid::stated_sheet(stated(), node(), installed()));
  CHECK(profile.driver == DeviceDriver::kHid);
  CHECK(profile.peak_force == 9.0);
  CHECK(profile.continuous_force == 3.0);
  CHECK(profile.stiffness_max == 3000.0);
  CHECK(profile.actuated_axes == 3);
  CHECK(profile.sensed_axes == 6);
  CHECK(profile.report_rate == 1000.0);
  CHECK(profile.workspace_lower == Array3{-0.1, -0.05, -0.06});
  CHECK(profile.workspace_upper == Array3{0.1, 0.05, 0.06});
  CHECK(profile.damping == 0.0);
}

TEST_CASE("a workspace stated along the device's own axes is the same room in D") {
  DeviceSheet base = installed();
  // Raw -z, x, -y become x, y, z of D.
  base.axes.raw_axis = {2, 0, 1};
  base.axes.sign = {-1.0, 1.0, -1.0};
  base.axes_stated = true;
  hid::Capabilities capabilities = stated();
  capabilities.ws_min_mm = {-100, -50, -20};
  capabilities.ws_max_mm = {90, 40, 60};
  const DeviceProfile profile = numbers(hid::stated_sheet(capabilities, node(), base));
  CHECK(profile.workspace_lower == Array3{-0.06, -0.1, -0.04});
  CHECK(profile.workspace_upper == Array3{0.02, 0.09, 0.05});
}

TEST_CASE("of two limits the lower one counts, whoever states it") {
  DeviceSheet base = installed();
  state_number(base, &DeviceProfile::peak_force, {4.0}, {0, "a test", false});
  state_number(base, &DeviceProfile::stiffness_max, {5000.0}, {0, "a test", false});
  const DeviceSheet made = hid::stated_sheet(stated(), node(), base);
  CHECK(numbers(made).peak_force == 4.0);
  CHECK(numbers(made).stiffness_max == 3000.0);
  CHECK(source_of(made, &DeviceProfile::peak_force).text == "a test");
  CHECK(source_of(made, &DeviceProfile::stiffness_max).text == "the device's capabilities");
}

TEST_CASE("what a device does not state stays as the profile has it") {
  hid::Capabilities silent = stated();
  silent.f_cont_cn = 0;
  silent.k_max_npm = 0;
  silent.ws_max_mm = silent.ws_min_mm;
  const DeviceProfile profile = numbers(hid::stated_sheet(silent, node(), installed()));
  CHECK(profile.continuous_force == profile.peak_force);
  CHECK(profile.stiffness_max == kUnlimited);
  CHECK(profile.workspace_upper[0] == kUnlimited);
}

TEST_CASE("a device that states no force gets none, which is not what a profile leaves open") {
  hid::Capabilities weak = stated();
  weak.f_peak_cn = weak.f_cont_cn = 0;
  const DeviceProfile profile = numbers(hid::stated_sheet(weak, node(), installed()));
  CHECK(profile.peak_force == 0.0);
  CHECK(profile.continuous_force == 0.0);
  CHECK(profile.peak_torque == 0.0);
  CHECK(numbers(hid::stated_sheet(stated(), node(), installed())).peak_torque == 0.0);
}

}  // namespace hapticd::test
