// The program that udev asks, run as udev runs it, on folders like those in sysfs. Truth: the
// descriptors of the profile's specification, of the HID specification's examples, and of a force
// device written by hand.
#include <doctest/doctest.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "device/hid/report_descriptor.h"
#include "tests/device/pid/force_device.h"
#include "tests/support/shell_run.h"

namespace hapticd {
namespace {

namespace fs = std::filesystem;

/// HID 1.11, appendix E.10: a mouse of three buttons.
constexpr std::array<std::uint8_t, 50> kMouse{
    0x05, 0x01, 0x09, 0x02, 0xA1, 0x01, 0x09, 0x01, 0xA1, 0x00, 0x05, 0x09, 0x19,
    0x01, 0x29, 0x03, 0x15, 0x00, 0x25, 0x01, 0x95, 0x03, 0x75, 0x01, 0x81, 0x02,
    0x95, 0x01, 0x75, 0x05, 0x81, 0x01, 0x05, 0x01, 0x09, 0x30, 0x09, 0x31, 0x15,
    0x81, 0x25, 0x7F, 0x75, 0x08, 0x95, 0x02, 0x81, 0x06, 0xC0, 0xC0};

/// What it prints, without its complaints.
test::ShellOutcome run(const std::string& arguments) {
  return test::run_in_shell(std::string(HAPTICD_ID_PROGRAM) + " " + arguments + " 2>/dev/null");
}

/// What it says of a device with this descriptor; none: without the file.
test::ShellOutcome ask(const std::optional<std::vector<std::uint8_t>>& descriptor) {
  std::string pattern = (fs::temp_directory_path() / "hapticd_id_XXXXXX").string();
  REQUIRE(mkdtemp(pattern.data()) != nullptr);
  const fs::path folder = pattern;
  fs::create_directory(folder / "device");
  if (descriptor) {
    std::ofstream(folder / "device/report_descriptor", std::ios::binary)
        .write(reinterpret_cast<const char*>(descriptor->data()),
               static_cast<std::streamsize>(descriptor->size()));
  }
  test::ShellOutcome said = run(folder.string());
  fs::remove_all(folder);
  return said;
}

std::vector<std::uint8_t> bytes(std::span<const std::uint8_t> all) {
  return {all.begin(), all.end()};
}

}  // namespace

TEST_CASE("a device of the profile is named, with and without the affine command") {
  for (const auto& descriptor : {bytes(hid::kPlainDescriptor), bytes(hid::kAffineDescriptor)}) {
    const test::ShellOutcome said = ask(descriptor);
    CHECK(said.code == 0);
    CHECK(said.text == "ID_HAPTICD=1\n");
  }
}

TEST_CASE("a force device of the PID class is named, and without its second axis it is not") {
  const test::ShellOutcome said = ask(test::DescriptorParts{}.joined());
  CHECK(said.code == 0);
  CHECK(said.text == "ID_HAPTICD=pid\n");
  test::DescriptorParts one_axis;
  one_axis.axes[5] = 0x38;  // a wheel where Y was
  const test::ShellOutcome other = ask(one_axis.joined());
  CHECK(other.code == 0);
  CHECK(other.text.empty());
}

TEST_CASE("of another device it says nothing, and that is no error") {
  std::vector<std::uint8_t> cut = bytes(hid::kPlainDescriptor);
  cut.pop_back();
  std::vector<std::uint8_t> too_long = bytes(hid::kPlainDescriptor);
  too_long.resize(kMaxDescriptor + 100);
  for (const auto& descriptor : {bytes(kMouse), cut, too_long}) {
    const test::ShellOutcome said = ask(descriptor);
    CHECK(said.code == 0);
    CHECK(said.text.empty());
  }
}

TEST_CASE("without a descriptor, or asked wrongly, it fails and says nothing to udev") {
  for (const test::ShellOutcome& said : {ask(std::nullopt), ask(std::vector<std::uint8_t>{}),
                                         run(""), run("/nowhere /else"), run("/nowhere")}) {
    CHECK(said.code != 0);
    CHECK(said.text.empty());
  }
}

}  // namespace hapticd
