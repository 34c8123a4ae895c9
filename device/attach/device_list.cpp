// See device_list.h.
#include "device/attach/device_list.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "device/attach/drivers.h"

namespace hapticd {
namespace {

using Json = nlohmann::ordered_json;

std::string ids(const HidrawNode& node) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%04x:%04x", unsigned{node.vendor_id},
                unsigned{node.product_id});
  return text.data();
}

Json json_of(const ListedDevice& device) {
  const HidrawNode& node = device.node;
  return {{"driver", std::string(device.driver->kind)},
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
    const DriverEntry* const driver = driver_for(node);
    if (driver == nullptr) continue;
    const std::string kind(driver->kind);
    devices.push_back({node, driver, node.serial.empty() ? kind : kind + ":" + node.serial});
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
    text += name + " (" + ids(node) + "), " + std::string(device.driver->what) + "\n";
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

}  // namespace hapticd
