// hapticd_id: says to udev whether a hidraw device speaks the HID profile of hapticd, whoever made
// it, is a force device of the PID class that hapticd can drive, or a SpaceMouse: run by
// deploy/udev/70-hapticd.rules with the device's folder in sysfs, it prints ID_HAPTICD=1,
// ID_HAPTICD=pid, ID_HAPTICD=spacemouse or nothing. Reads the report descriptor alone: the device
// is not opened.
#include <array>
#include <cstdio>
#include <fstream>
#include <span>
#include <string>

#include "device/hid/report_descriptor.h"
#include "device/pid/pid_layout.h"
#include "device/spacemouse/spacemouse_report.h"

namespace {

/// One byte more than any descriptor has: a longer file is refused as such.
constexpr std::size_t kRoom = hapticd::kMaxDescriptor + 1;
constexpr int kUnreadable = 1;
constexpr int kMisused = 2;

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fputs("usage: hapticd_id FOLDER_OF_A_HIDRAW_DEVICE_IN_SYSFS\n", stderr);
    return kMisused;
  }
  const std::string path = std::string(arguments[1]) + "/device/report_descriptor";
  std::array<char, kRoom> bytes{};
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (file.bad() || file.gcount() <= 0) {
    std::fprintf(stderr, "hapticd_id: cannot read %s\n", path.c_str());
    return kUnreadable;
  }
  const std::span all(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  const auto descriptor = all.first(static_cast<std::size_t>(file.gcount()));
  if (is_profile_v1(hapticd::hid::read_descriptor(descriptor))) {
    std::puts("ID_HAPTICD=1");
  } else if (hapticd::pid::find_layout(descriptor).lack.empty()) {
    std::puts("ID_HAPTICD=pid");
  } else if (hapticd::spacemouse::has_six_axes(descriptor)) {
    std::puts("ID_HAPTICD=spacemouse");
  }
  return 0;
}
