// What becomes of a force device without a watchdog, and who else may push with it. Truth: the
// numbers put in, and folders like those in sysfs.
#include "device/pid/pid_driver.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "device/report_io/hidraw_handles.h"
#include "server/scene_io/profile_loader.h"
#include "tests/device/pid/force_device.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;

HidrawNode stick(std::uint16_t vendor, std::uint16_t product) {
  HidrawNode made;
  made.path = "/dev/hidraw7";
  made.serial = "S1";
  made.product = "Stick";
  made.vendor_id = vendor;
  made.product_id = product;
  made.descriptor = DescriptorParts{}.joined();
  return made;
}

DeviceSheet shipped(const std::string& name) {
  ProfileResult result =
      load_profile(std::string(HAPTICD_SOURCE_DIR "/deploy/devices/") + name + ".textproto", {});
  REQUIRE(result.loaded.has_value());
  return *result.loaded;
}

std::vector<DeviceSheet> shipped_ones() {
  return {shipped("openffboard"), shipped("vpforce_rhino")};
}

std::string name_of(const DeviceSheet& sheet) { return std::string(device_name(sheet.profile)); }

/// The name of the profile that a device of these numbers gets.
std::string chosen(std::uint16_t vendor, std::uint16_t product, const char* base = "pid") {
  const std::vector<DeviceSheet> all = shipped_ones();
  return name_of(pid::matching_sheet(stick(vendor, product), shipped(base), all));
}

DeviceSheet limited(const DeviceSheet& base) {
  const HidrawNode node = stick(0x1209, 0xffb0);
  return pid::unwatched_sheet(node, pid::find_layout(node.descriptor).layout, base);
}

/// A folder like /sys with one input device of the node; its force effects as the kernel writes
/// them.
struct Sys {
  explicit Sys(const std::string& effects) {
    std::string pattern = (fs::temp_directory_path() / "hapticd_sys_XXXXXX").string();
    REQUIRE(mkdtemp(pattern.data()) != nullptr);
    folder = pattern;
    const fs::path input = fs::path(folder) / "class/hidraw/hidraw7/device/input/input3";
    fs::create_directories(input / "capabilities");
    fs::create_directories(input / "event5");
    fs::create_directories(input / "js0");
    std::ofstream(input / "capabilities/ff") << effects << "\n";
  }
  ~Sys() { fs::remove_all(folder); }
  Sys(const Sys&) = delete;
  Sys& operator=(const Sys&) = delete;
  std::string folder;
};

}  // namespace

TEST_CASE("a force device is told by its descriptor") {
  CHECK(pid::is_mine(stick(1, 2)));
  HidrawNode other = stick(1, 2);
  other.descriptor.clear();
  CHECK_FALSE(pid::is_mine(other));
}

TEST_CASE("a force device has the profile of its maker's numbers, unless one is chosen by name") {
  CHECK(chosen(0x1209, 0xffb0) == "openffboard");
  CHECK(chosen(0xffff, 0x2055) == "vpforce_rhino");
  CHECK(chosen(0x1209, 0x0001) == "pid");
  CHECK(chosen(0x1209, 0xffb0, "vpforce_rhino") == "vpforce_rhino");
}

TEST_CASE("of two profiles for a device the one that says more of it counts") {
  std::vector<DeviceSheet> all = shipped_ones();
  DeviceSheet mine = all.front();
  mine.profile.name = {'m', 'i', 'n', 'e'};
  mine.matches.front().serial = "S1";
  all.push_back(mine);
  const DeviceSheet base = shipped("pid");
  CHECK(name_of(pid::matching_sheet(stick(0x1209, 0xffb0), base, all)) == "mine");
  HidrawNode other = stick(0x1209, 0xffb0);
  other.serial = "S2";
  CHECK(name_of(pid::matching_sheet(other, base, all)) == "openffboard");
}

TEST_CASE("a profile for joysticks of any maker is told by the usage of the descriptor") {
  DeviceSheet joysticks = shipped("openffboard");
  DeviceMatch match;
  match.usage_page = 1;
  match.usage = 4;
  joysticks.matches = {match};
  const DeviceSheet base = shipped("pid");
  CHECK(name_of(pid::matching_sheet(stick(1, 2), base, {&joysticks, 1})) == "openffboard");
  DeviceSheet wheels = joysticks;
  wheels.matches.front().usage = 5;
  CHECK(name_of(pid::matching_sheet(stick(1, 2), base, {&wheels, 1})) == "pid");
}

TEST_CASE("no profile gets more than 1 N from a device without a watchdog, or says it has one") {
  DeviceSheet strong = shipped("openffboard");
  state_number(strong, &DeviceProfile::peak_force, {50.0}, {0, "a test", false});
  state_number(strong, &DeviceProfile::watchdog, {0.02}, {0, "a test", false});
  strong.profile.driver = DeviceDriver::kHid;
  const DeviceSheet made = limited(strong);
  CHECK(made.profile.peak_force == 1.0);
  CHECK(source_of(made, &DeviceProfile::peak_force).text == "there is no device watchdog");
  CHECK(is_open(made, &DeviceProfile::watchdog));
  CHECK(made.profile.watchdog == kUnlimited);
  CHECK(made.description.find("no device watchdog") != std::string::npos);
  CHECK(made.profile.driver == DeviceDriver::kPid);
  state_number(strong, &DeviceProfile::peak_force, {0.5}, {0, "a test", false});
  CHECK(limited(strong).profile.peak_force == 0.5);
}

TEST_CASE("a device whose newtons nobody knows is refused with the profile to write") {
  const auto refused = [](const char* part) {
    CHECK_THROWS_WITH_AS(static_cast<void>(limited(shipped("pid"))), doctest::Contains(part),
                         DeviceError);
  };
  refused("matches { vendor_id: 0x1209 product_id: 0xffb0 }");
  refused("force_scale the newtons that it gives at most divided by 32767");
  refused("divided by 65534");
}

TEST_CASE("the nodes are named through which the kernel lets others push") {
  const HidrawNode node = stick(1, 2);
  CHECK(pid::force_inputs(node, Sys("3f 0 0").folder) ==
        std::vector<std::string>{"/dev/input/event5"});
  CHECK(pid::force_inputs(node, Sys("0").folder).empty());
  CHECK(pid::force_inputs(node, "/nowhere").empty());
}

}  // namespace hapticd::test
