// What becomes of a force device without a watchdog, and who else may push with it. Truth: the
// numbers put in, and folders like those in sysfs.
#include "server/devices/pid_attachment.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "device/hid/report_descriptor.h"
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

v1::DeviceProfile shipped(const std::string& name) {
  ProfileResult result =
      load_profile(std::string(HAPTICD_SOURCE_DIR "/deploy/devices/") + name + ".textproto", {});
  REQUIRE(result.loaded.has_value());
  return result.loaded->message;
}

std::vector<v1::DeviceProfile> shipped_ones() {
  return {shipped("openffboard"), shipped("vpforce_rhino")};
}

/// The name of the profile that a device of these numbers gets.
std::string chosen(std::uint16_t vendor, std::uint16_t product, const char* base = "pid") {
  const std::vector<v1::DeviceProfile> all = shipped_ones();
  const v1::DeviceProfile given = shipped(base);
  return pid_base(stick(vendor, product), given, all).name();
}

v1::DeviceProfile limited(const v1::DeviceProfile& base) {
  const HidrawNode node = stick(0x1209, 0xffb0);
  return pid_profile(node, pid::find_layout(node.descriptor).layout, base);
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

TEST_CASE("a force device is told by its descriptor, and one of the HID profile is another") {
  CHECK(is_pid(stick(1, 2)));
  HidrawNode other = stick(1, 2);
  other.descriptor.assign(hid::kPlainDescriptor.begin(), hid::kPlainDescriptor.end());
  CHECK_FALSE(is_pid(other));
  other.descriptor.clear();
  CHECK_FALSE(is_pid(other));
}

TEST_CASE("a force device has the profile of its maker's numbers, unless one is chosen by name") {
  CHECK(chosen(0x1209, 0xffb0) == "openffboard");
  CHECK(chosen(0xffff, 0x2055) == "vpforce_rhino");
  CHECK(chosen(0x1209, 0x0001) == "pid");
  CHECK(chosen(0x1209, 0xffb0, "vpforce_rhino") == "vpforce_rhino");
}

TEST_CASE("of two profiles for a device the one that says more of it counts") {
  std::vector<v1::DeviceProfile> all = shipped_ones();
  v1::DeviceProfile mine = all.front();
  mine.set_name("mine");
  mine.mutable_matches(0)->set_serial("S1");
  all.push_back(mine);
  const v1::DeviceProfile base = shipped("pid");
  CHECK(pid_base(stick(0x1209, 0xffb0), base, all).name() == "mine");
  HidrawNode other = stick(0x1209, 0xffb0);
  other.serial = "S2";
  CHECK(pid_base(other, base, all).name() == "openffboard");
}

TEST_CASE("a profile for joysticks of any maker is told by the usage of the descriptor") {
  v1::DeviceProfile joysticks = shipped("openffboard");
  joysticks.clear_matches();
  v1::DeviceMatch& match = *joysticks.add_matches();
  match.set_usage_page(1);
  match.set_usage(4);
  const v1::DeviceProfile base = shipped("pid");
  const std::vector<v1::DeviceProfile> all{joysticks};
  CHECK(pid_base(stick(1, 2), base, all).name() == "openffboard");
  const std::vector<v1::DeviceProfile> none{[&] {
    v1::DeviceProfile wheels = joysticks;
    wheels.mutable_matches(0)->set_usage(5);
    return wheels;
  }()};
  CHECK(pid_base(stick(1, 2), base, none).name() == "pid");
}

TEST_CASE("no profile gets more than 1 N from a device without a watchdog, or says it has one") {
  v1::DeviceProfile strong = shipped("openffboard");
  strong.mutable_peak_force_n()->set_value(0, 50.0);
  strong.mutable_watchdog_s()->add_value(0.02);
  strong.mutable_watchdog_s()->set_source("a test");
  strong.set_driver(v1::DRIVER_HID);
  const v1::DeviceProfile made = limited(strong);
  CHECK(made.peak_force_n().value(0) == 1.0);
  CHECK(made.peak_force_n().source() == "there is no device watchdog");
  CHECK_FALSE(made.has_watchdog_s());
  CHECK(made.description().find("no device watchdog") != std::string::npos);
  CHECK(made.driver() == v1::DRIVER_PID);
  strong.mutable_peak_force_n()->set_value(0, 0.5);
  CHECK(limited(strong).peak_force_n().value(0) == 0.5);
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
  CHECK(force_inputs(node, Sys("3f 0 0").folder) == std::vector<std::string>{"/dev/input/event5"});
  CHECK(force_inputs(node, Sys("0").folder).empty());
  CHECK(force_inputs(node, "/nowhere").empty());
}

}  // namespace hapticd::test
