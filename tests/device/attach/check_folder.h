// A folder of its own for records of checks, and a device to be checked.
#pragma once

#include <doctest/doctest.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "device/attach/device_check.h"

namespace hapticd::test {

/// Removed at the end.
class CheckFolder {
 public:
  CheckFolder() {
    spdlog::set_level(spdlog::level::off);  // hundreds of files that do not count
    std::string name = std::filesystem::temp_directory_path() / "hapticd_check_XXXXXX";
    REQUIRE(mkdtemp(name.data()) != nullptr);
    top_ = name;
  }
  ~CheckFolder() { std::filesystem::remove_all(top_); }
  CheckFolder(const CheckFolder&) = delete;
  CheckFolder& operator=(const CheckFolder&) = delete;

  /// Made by who first writes into it.
  [[nodiscard]] std::filesystem::path path() const { return top_ / "state" / "devices"; }

 private:
  std::filesystem::path top_;
};

inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void set_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

inline HidrawNode pen(const std::string& serial = "S1") {
  HidrawNode node;
  node.path = "/dev/hidraw7";
  node.serial = serial;
  node.product = "Pen \"B\"";
  node.vendor_id = 0x1209;
  node.product_id = 1;
  return node;
}

/// What a device says of itself.
const std::vector<std::uint8_t> kStated{16, 1, 2, 3, 255, 0, 7};

}  // namespace hapticd::test
