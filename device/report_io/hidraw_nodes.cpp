// See hidraw_nodes.h.
#include "device/report_io/hidraw_nodes.h"

#include <hidapi/hidapi.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>

namespace hapticd {
namespace {

/// The printable ASCII of a string that a device sent; the rest becomes '?'.
std::string text_of(const wchar_t* wide) {
  std::string text;
  for (; wide != nullptr && *wide != L'\0'; ++wide) {
    text += *wide >= L' ' && *wide <= L'~' ? static_cast<char>(*wide) : '?';
  }
  return text;
}

std::vector<std::uint8_t> descriptor_of(const std::string& path, const std::string& sys) {
  const std::string name = std::filesystem::path(path).filename();
  std::ifstream file(sys + "/class/hidraw/" + name + "/device/report_descriptor", std::ios::binary);
  std::vector<std::uint8_t> bytes(kMaxHidDescriptor);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  return bytes;
}

}  // namespace

std::vector<HidrawNode> list_hidraw_nodes(const std::string& sys) {
  std::vector<HidrawNode> nodes;
  const std::unique_ptr<hid_device_info, void (*)(hid_device_info*)> all(hid_enumerate(0, 0),
                                                                         hid_free_enumeration);
  for (const hid_device_info* each = all.get(); each != nullptr; each = each->next) {
    if (each->path == nullptr) continue;
    const std::string path = each->path;
    const auto known = [&](const HidrawNode& node) { return node.path == path; };
    if (std::any_of(nodes.begin(), nodes.end(), known)) continue;
    HidrawNode& node = nodes.emplace_back();
    node.path = path;
    node.serial = text_of(each->serial_number);
    node.maker = text_of(each->manufacturer_string);
    node.product = text_of(each->product_string);
    node.vendor_id = each->vendor_id;
    node.product_id = each->product_id;
    node.descriptor = descriptor_of(path, sys);
    node.permitted = access(path.c_str(), R_OK | W_OK) == 0;
  }
  std::sort(nodes.begin(), nodes.end(),
            [](const HidrawNode& a, const HidrawNode& b) { return a.path < b.path; });
  return nodes;
}

std::string describe(const HidrawNode& node) {
  std::string text = node.product.empty() ? "HID device" : node.product;
  if (!node.serial.empty()) text += " " + node.serial;
  return text + " at " + node.path;
}

}  // namespace hapticd
