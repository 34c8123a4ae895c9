// What is plugged in, as people and programs are told of it. Truth: the devices put in.
#include "device/attach/device_list.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "device/hid/report_descriptor.h"
#include "tests/device/pid/force_device.h"

namespace hapticd::test {
namespace {

HidrawNode node(const std::string& path, const std::string& product, const std::string& serial) {
  HidrawNode made;
  made.path = path;
  made.product = product;
  made.serial = serial;
  made.permitted = true;
  return made;
}

/// One for each driver, and a mouse.
std::vector<HidrawNode> plugged() {
  std::vector<HidrawNode> all{
      node("/dev/hidraw0", "Pen", "P7"), node("/dev/hidraw1", "Mouse", "M1"),
      node("/dev/hidraw2", "SpaceNavigator", ""), node("/dev/hidraw3", "A \"Stick\"", "S1")};
  all[0].descriptor.assign(hid::kPlainDescriptor.begin(), hid::kPlainDescriptor.end());
  all[2].vendor_id = 0x046D;
  all[2].product_id = 0xC626;
  all[3].descriptor = DescriptorParts{}.joined();
  all[3].vendor_id = 0x1209;
  all[3].product_id = 0xFFB0;
  return all;
}

}  // namespace

TEST_CASE("of what is plugged in, each device that has a driver is listed with its choice") {
  const std::vector<ListedDevice> devices = drivable(plugged());
  REQUIRE(devices.size() == 3);
  CHECK(devices[0].choice == "hid:P7");
  CHECK(devices[1].choice == "spacemouse");
  CHECK(devices[2].choice == "pid:S1");
  CHECK(devices[2].driver->driver == DeviceDriver::kPid);
}

TEST_CASE(
    "a device that may not be opened is said to be so, with the remedy and by the exit code") {
  std::vector<HidrawNode> nodes = plugged();
  CHECK(list_exit_code(drivable(nodes)) == kListGood);
  CHECK(list_text(drivable(nodes)).find("usermod") == std::string::npos);
  nodes[1].permitted = false;  // the mouse is nobody's concern
  CHECK(list_exit_code(drivable(nodes)) == kListGood);
  nodes[0].permitted = false;
  const std::vector<ListedDevice> devices = drivable(nodes);
  CHECK(list_exit_code(devices) == kListForbidden);
  CHECK(list_text(devices).find("/dev/hidraw0, not permitted") != std::string::npos);
  CHECK(list_text(devices).find("usermod -aG hapticd") != std::string::npos);
}

TEST_CASE("where nothing is plugged in the simulated device is named") {
  CHECK(list_text({}).find("--device simulated") != std::string::npos);
  CHECK(list_json({}) == "{\"devices\":[]}\n");
  CHECK(list_exit_code({}) == kListGood);
}

TEST_CASE("programs are told the same, with quotes kept apart") {
  const std::string json = list_json(drivable(plugged()));
  CHECK(
      json.find(R"("driver":"pid","product":"A \"Stick\"","maker":"","serial":"S1",)"
                R"("ids":"1209:ffb0","node":"/dev/hidraw3","permitted":true,"device":"pid:S1")") !=
      std::string::npos);
}

}  // namespace hapticd::test
