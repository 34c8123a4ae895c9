// See device_list.h.
#include "server/devices/device_list.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "device/hid/report_descriptor.h"
#include "device/spacemouse/spacemouse_device.h"
#include "server/devices/pid_attachment.h"

namespace hapticd {
namespace {

using Json = nlohmann::ordered_json;

const char* word_of(DeviceDriver driver) {
  if (driver == DeviceDriver::kPid) return "pid";
  return driver == DeviceDriver::kSpacemouse ? "spacemouse" : "hid";
}

const char* meaning_of(DeviceDriver driver) {
  if (driver == DeviceDriver::kPid) return "two-axis force device, experimental, no watchdog";
  return driver == DeviceDriver::kSpacemouse ? "moves a tool, without force" : "haptic device";
}

std::optional<DeviceDriver> driver_of(const HidrawNode& node) {
  if (is_profile_v1(hid::read_descriptor(node.descriptor))) return DeviceDriver::kHid;
  if (spacemouse::is_spacemouse(node.vendor_id, node.product_id)) return DeviceDriver::kSpacemouse;
  if (is_pid(node)) return DeviceDriver::kPid;
  return std::nullopt;
}

std::string ids(const HidrawNode& node) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%04x:%04x", unsigned{node.vendor_id},
                unsigned{node.product_id});
  return text.data();
}

Json json_of(const ListedDevice& device) {
  const HidrawNode& node = device.node;
  return {{"driver", word_of(device.driver)},
          {"product", node.product},
          {"maker", node.maker},
          {"serial", node.serial},
          {"ids", ids(node)},
          {"node", node.path},
          {"permitted", node.permitted},
          {"device", device.choice}};
}

}  // namespace

std::vector<ListedDevice> drivable(std::span<const HidrawNode> nodes) {
  std::vector<ListedDevice> devices;
  devices.reserve(nodes.size());
  for (const HidrawNode& node : nodes) {
    const std::optional<DeviceDriver> driver = driver_of(node);
    if (!driver) continue;
    const std::string kind = word_of(*driver);
    devices.push_back({node, *driver, node.serial.empty() ? kind : kind + ":" + node.serial});
  }
  return devices;
}

std::string list_text(std::span<const ListedDevice> devices) {
  if (devices.empty()) {
    return "No device is plugged in that hapticd can drive. hapticd --device simulated, the "
           "default, needs none.\n";
  }
  std::string text;
  for (const ListedDevice& device : devices) {
    const HidrawNode& node = device.node;
    const std::string name = node.product.empty() ? "HID device" : node.product;
    text += name + " (" + ids(node) + "), " + meaning_of(device.driver) + "\n";
    text += "  start with  hapticd --device " + device.choice + "\n";
    text += "  serial      " + (node.serial.empty() ? std::string("none") : node.serial) + "\n";
    text += "  node        " + node.path + (node.permitted ? "" : ", not permitted") + "\n";
  }
  if (list_exit_code(devices) == kListForbidden) {
    text +=
        "To be permitted, install deploy/udev/70-hapticd.rules, join its group with 'sudo usermod "
        "-aG hapticd $USER', and log in again.\n";
  }
  return text;
}

std::string list_json(std::span<const ListedDevice> devices) {
  Json listed = Json::array();
  for (const ListedDevice& device : devices) listed.push_back(json_of(device));
  const Json json = {{"devices", listed}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

int list_exit_code(std::span<const ListedDevice> devices) {
  const bool all = std::all_of(devices.begin(), devices.end(),
                               [](const ListedDevice& device) { return device.node.permitted; });
  return all ? kListGood : kListForbidden;
}

int run_device_list(int argc, const char* const* argv) {
  bool json = false;
  CLI::App app("Devices of this machine.", "hapticd device");
  CLI::App* list = app.add_subcommand("list", "what is plugged in that hapticd can drive");
  list->add_flag("--json", json, "as JSON, for programs");
  app.require_subcommand(1);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kListGood : kListUsage;
  }
  const std::vector<HidrawNode> nodes = list_hidraw_nodes();
  const std::vector<ListedDevice> devices = drivable(nodes);
  std::fputs((json ? list_json(devices) : list_text(devices)).c_str(), stdout);
  return list_exit_code(devices);
}

}  // namespace hapticd
