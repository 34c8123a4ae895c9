// The rules for udev, run by systemd's udevd in a guest (udev.py), on devices that the kernel
// believes in. Truth: owner, mode and links of the nodes, and what other users may open.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <grp.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "device/report_io/hidraw_nodes.h"
#include "tests/vm/attached_loop.h"
#include "tests/vm/uhid_device.h"
#include "tests/vm/usbip_device.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;

/// As in udev.py; and someone else.
constexpr gid_t kHapticdGroup = 990;
constexpr uid_t kMember = 990;
constexpr uid_t kStranger = 65534;

/// One input report of 8 bytes, of a page of its own that is not ours.
const std::vector<std::uint8_t> kOtherDescriptor{0x06, 0x49, 0xFF, 0x09, 0x01, 0xA1, 0x01,
                                                 0x15, 0x00, 0x26, 0xFF, 0x00, 0x75, 0x08,
                                                 0x95, 0x08, 0x09, 0x01, 0x81, 0x02, 0xC0};

void must(const std::string& command) {
  CAPTURE(command);
  // NOLINTNEXTLINE(concurrency-mt-unsafe): no thread here changes the environment
  REQUIRE(std::system(command.c_str()) == 0);
}

/// Starts udevd, once; it goes down with the guest.
void start_udev() {
  static const bool started = [] {
    must("systemd-udevd --daemon");
    return true;
  }();
  REQUIRE(started);
}

/// The node of this serial, when udev has dealt with it.
HidrawNode settled(const std::string& serial) {
  for (int k = 0; k < 200; ++k) {
    for (const HidrawNode& node : list_hidraw_nodes()) {
      if (node.serial != serial) continue;
      must("udevadm settle");
      return node;
    }
    sleep_ms(10);
  }
  FAIL("no device " << serial);
  return {};
}

std::string name_of(const HidrawNode& node) { return fs::path(node.path).filename(); }

struct stat facts_of(const HidrawNode& node) {
  struct stat facts {};
  REQUIRE(stat(node.path.c_str(), &facts) == 0);
  return facts;
}

bool is_ours(const HidrawNode& node) {
  const struct stat facts = facts_of(node);
  const fs::path link = "/dev/hapticd/" + name_of(node);
  std::error_code error;
  return facts.st_uid == 0 && facts.st_gid == kHapticdGroup && (facts.st_mode & 0777U) == 0660 &&
         fs::canonical(link, error) == node.path;
}

/// Whether a user with this group and no other may open the node.
bool may_open(const HidrawNode& node, uid_t user, gid_t group) {
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    const bool changed = setgroups(0, nullptr) == 0 && setgid(group) == 0 && setuid(user) == 0;
    if (!changed) _exit(2);
    _exit(open(node.path.c_str(), O_RDWR | O_CLOEXEC) >= 0 ? 0 : 1);
  }
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  REQUIRE(WIFEXITED(status));
  REQUIRE(WEXITSTATUS(status) != 2);
  return WEXITSTATUS(status) == 0;
}

/// What hapticd_id prints of a node.
std::string said_of(const HidrawNode& node) {
  const std::string command = "/lib/udev/hapticd_id /sys/class/hidraw/" + name_of(node);
  FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::array<char, 64> room{};
  std::string text;
  while (std::fgets(room.data(), static_cast<int>(room.size()), pipe) != nullptr) {
    text += room.data();
  }
  CHECK(pclose(pipe) == 0);
  return text;
}

}  // namespace

TEST_CASE("any maker's device of the profile is the group's, and its members alone may open it") {
  start_udev();
  FirmwareOptions options;
  options.vendor_id = 0xCAFE;
  options.product_id = 0x1234;
  UhidDevice plugged(options);
  const HidrawNode node = settled("A1");
  CHECK(said_of(node) == "ID_HAPTICD=1\n");
  CHECK(is_ours(node));
  CHECK(may_open(node, kMember, kHapticdGroup));
  CHECK_FALSE(may_open(node, kStranger, kStranger));
}

TEST_CASE("another HID device stays root's") {
  start_udev();
  FirmwareOptions options;
  options.descriptor = kOtherDescriptor;
  UhidDevice plugged(options);
  const HidrawNode node = settled("A1");
  CHECK(said_of(node).empty());
  CHECK_FALSE(is_ours(node));
  CHECK(facts_of(node).st_gid == 0);
  CHECK_FALSE(may_open(node, kMember, kHapticdGroup));
  CHECK_FALSE(fs::exists("/dev/hapticd/" + name_of(node)));
}

TEST_CASE("a SpaceMouse is the group's by its number") {
  start_udev();
  FirmwareOptions options;
  options.descriptor = kOtherDescriptor;
  options.vendor_id = 0x256F;
  options.product_id = 0xC635;
  UhidDevice plugged(options);
  CHECK(is_ours(settled("A1")));
}

TEST_CASE("a device on USB is kept awake, and its link goes with it") {
  start_udev();
  std::optional<UsbipDevice> plugged;
  plugged.emplace(FirmwareOptions{});
  const HidrawNode node = settled("A1");
  CHECK(is_ours(node));
  const fs::path control =
      fs::canonical("/sys/class/hidraw/" + name_of(node) + "/device") / "../../power/control";
  std::ofstream(control) << "auto";
  must("udevadm trigger --settle --action=change --subsystem-match=hidraw");
  std::string state;
  std::ifstream(control) >> state;
  CHECK(state == "on");
  const std::string link = "/dev/hapticd/" + name_of(node);
  CHECK(fs::exists(link));
  plugged.reset();
  sleep_ms(500);
  must("udevadm settle");
  CHECK_FALSE(fs::exists(fs::symlink_status(link)));
}

}  // namespace hapticd::test
