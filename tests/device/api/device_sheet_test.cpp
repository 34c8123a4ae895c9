// What a driver and a profile's author make of a number together. Truth: the numbers put in.
#include "device/api/device_sheet.h"

#include <doctest/doctest.h>

namespace hapticd::test {

TEST_CASE("a device fills in what its profile leaves open, and nothing else") {
  DeviceSheet sheet;
  state_number(sheet, &DeviceProfile::watchdog, {0.1}, {0, "the author", true});
  fill(sheet, &DeviceProfile::watchdog, {0.02});
  fill(sheet, &DeviceProfile::workspace_lower, {-1.0, -2.0, -3.0});
  fill(sheet, &DeviceProfile::sensed_axes, {3.0});
  CHECK(sheet.profile.watchdog == 0.1);
  CHECK(source_of(sheet, &DeviceProfile::watchdog).text == "the author");
  CHECK(source_of(sheet, &DeviceProfile::watchdog).guess);
  CHECK(sheet.profile.workspace_lower == Array3{-1.0, -2.0, -3.0});
  CHECK(source_of(sheet, &DeviceProfile::workspace_lower).text == "the device's capabilities");
  CHECK(sheet.profile.sensed_axes == 3);
  CHECK(is_open(sheet, &DeviceProfile::actuated_axes));
}

TEST_CASE("of two limits the lower one holds, with its source; unlimited is none, and 0 is one") {
  DeviceSheet sheet;
  limit(sheet, &DeviceProfile::peak_force, kUnlimited);
  CHECK(is_open(sheet, &DeviceProfile::peak_force));
  limit(sheet, &DeviceProfile::peak_force, 9.0);
  CHECK(sheet.profile.peak_force == 9.0);
  limit(sheet, &DeviceProfile::peak_force, 9.5, "somebody");
  CHECK(sheet.profile.peak_force == 9.0);
  limit(sheet, &DeviceProfile::peak_force, 0.0, "nobody");
  CHECK(sheet.profile.peak_force == 0.0);
  CHECK(source_of(sheet, &DeviceProfile::peak_force).text == "nobody");
  CHECK_FALSE(is_open(sheet, &DeviceProfile::peak_force));
}

TEST_CASE("a limit that is put in place of a guess is none") {
  DeviceSheet sheet;
  state_number(sheet, &DeviceProfile::peak_force, {20.0}, {0, "a guess", true});
  limit(sheet, &DeviceProfile::peak_force, 5.0);
  CHECK_FALSE(source_of(sheet, &DeviceProfile::peak_force).guess);
}

TEST_CASE("one value holds for every axis, and is told as one") {
  DeviceSheet sheet;
  state_number(sheet, &AxisMapping::force_scale, {0.5}, {0, "s", false});
  CHECK(sheet.axes.force_scale == Array3{0.5, 0.5, 0.5});
  CHECK(stated_values(sheet, &AxisMapping::force_scale) == std::vector<double>{0.5});
  state_number(sheet, &AxisMapping::force_scale, {1.0, 2.0, 3.0}, {0, "s", false});
  CHECK(stated_values(sheet, &AxisMapping::force_scale) == std::vector<double>{1.0, 2.0, 3.0});
}

TEST_CASE("what is left open has its default again") {
  DeviceSheet sheet;
  state_number(sheet, &DeviceProfile::watchdog, {0.1}, {0, "s", false});
  leave_open(sheet, &DeviceProfile::watchdog);
  CHECK(is_open(sheet, &DeviceProfile::watchdog));
  CHECK(sheet.profile.watchdog == kUnlimited);
  CHECK(stated_values(sheet, &DeviceProfile::watchdog).empty());
}

}  // namespace hapticd::test
