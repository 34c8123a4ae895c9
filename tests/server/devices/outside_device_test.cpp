// What becomes of a device's own word and a profile. Truth: the numbers put in.
#include <doctest/doctest.h>

#include "server/devices/outside_device.h"

namespace hapticd::test {
namespace {

v1::DeviceProfile installed() {
  ProfileResult result = load_profile(HAPTICD_SOURCE_DIR "/deploy/devices/hid_v1.textproto", {});
  REQUIRE(result.loaded.has_value());
  return result.loaded->message;
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

DeviceProfile numbers(const v1::DeviceProfile& message) {
  ProfileResult result = check_profile(message);
  for (const SceneProblem& problem : result.problems) FAIL_CHECK(to_text(problem));
  REQUIRE(result.loaded.has_value());
  return result.loaded->profile;
}

}  // namespace

TEST_CASE("what a device states fills in what the profile of every HID device leaves open") {
  const DeviceProfile profile = numbers(profile_of(stated(), node(), installed()));
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
  v1::DeviceProfile base = installed();
  for (const v1::Axis axis : {v1::AXIS_NEGATIVE_Z, v1::AXIS_POSITIVE_X, v1::AXIS_NEGATIVE_Y}) {
    base.mutable_axis_map()->add_axes(axis);
  }
  hid::Capabilities capabilities = stated();
  capabilities.ws_min_mm = {-100, -50, -20};
  capabilities.ws_max_mm = {90, 40, 60};
  const DeviceProfile profile = numbers(profile_of(capabilities, node(), base));
  CHECK(profile.workspace_lower == Array3{-0.06, -0.1, -0.04});
  CHECK(profile.workspace_upper == Array3{0.02, 0.09, 0.05});
}

TEST_CASE("of two limits the lower one counts, whoever states it") {
  v1::DeviceProfile base = installed();
  base.mutable_peak_force_n()->set_value(0, 4.0);
  base.mutable_stiffness_max_n_per_m()->add_value(5000.0);
  base.mutable_stiffness_max_n_per_m()->set_source("a test");
  const v1::DeviceProfile made = profile_of(stated(), node(), base);
  CHECK(numbers(made).peak_force == 4.0);
  CHECK(numbers(made).stiffness_max == 3000.0);
  CHECK(made.stiffness_max_n_per_m().source() == "the device's capabilities");
}

TEST_CASE("what a device does not state stays as the profile has it") {
  hid::Capabilities silent = stated();
  silent.f_cont_cn = 0;
  silent.k_max_npm = 0;
  silent.ws_max_mm = silent.ws_min_mm;
  const DeviceProfile profile = numbers(profile_of(silent, node(), installed()));
  CHECK(profile.continuous_force == profile.peak_force);
  CHECK(profile.stiffness_max == kUnlimited);
  CHECK(profile.workspace_upper[0] == kUnlimited);
}

TEST_CASE("a device that states no force gets none, which is not what a profile leaves open") {
  hid::Capabilities weak = stated();
  weak.f_peak_cn = weak.f_cont_cn = 0;
  const DeviceProfile profile = numbers(profile_of(weak, node(), installed()));
  CHECK(profile.peak_force == 0.0);
  CHECK(profile.continuous_force == 0.0);
  CHECK(profile.peak_torque == 0.0);
  CHECK(numbers(profile_of(stated(), node(), installed())).peak_torque == 0.0);
}

TEST_CASE("a source names a kind of device, and after a colon the serial of one") {
  REQUIRE(outside_source("hid").has_value());
  CHECK(outside_source("hid")->serial.empty());
  CHECK(outside_source("hid:A:1")->serial == "A:1");
  CHECK(outside_source("spacemouse:7")->driver == DeviceDriver::kSpacemouse);
  CHECK(outside_source("pid:7")->driver == DeviceDriver::kPid);
  CHECK(outside_source("pid")->profile == "pid");
  for (const char* other :
       {"", "hi", "hidx", "hid:", "simulated", "spacemouse:", "replay:x", "pi"}) {
    CAPTURE(other);
    CHECK_FALSE(outside_source(other).has_value());
  }
}

TEST_CASE("a device that is not there is refused with its serial and what to do") {
  const auto attach = [](const char* source) {
    static_cast<void>(attach_device(*outside_source(source), installed(), 1.0, "/nowhere"));
  };
  CHECK_THROWS_WITH_AS(attach("hid:none such"),
                       doctest::Contains("no hid device of serial none such is plugged in"),
                       std::runtime_error);
  CHECK_THROWS_WITH_AS(attach("pid:none such"),
                       doctest::Contains("no pid device of serial none such is plugged in"),
                       std::runtime_error);
  CHECK_THROWS_WITH_AS(attach("spacemouse"), doctest::Contains("--device simulated"),
                       std::runtime_error);
}

}  // namespace hapticd::test
