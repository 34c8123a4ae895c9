// The rules for udev against the driver they are for: not all SpaceMice have a descriptor to tell
// them by, so that their numbers stand in both. Receivers are told by their descriptors alone.
#include <doctest/doctest.h>

#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>
#include <utility>

#include "device/spacemouse/spacemouse_report.h"

namespace hapticd {
namespace {

std::string rules() {
  std::ifstream file(HAPTICD_SOURCE_DIR "/deploy/udev/70-hapticd.rules");
  REQUIRE(file);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

TEST_CASE("the rules name exactly the SpaceMice that the driver reads") {
  std::set<std::pair<int, int>> named;
  const std::string text = rules();
  const std::regex number(R"(\*:([0-9A-F]{4}):([0-9A-F]{4})\.\*)");
  for (std::sregex_iterator k(text.begin(), text.end(), number), end; k != end; ++k) {
    named.emplace(std::stoi((*k)[1], nullptr, 16), std::stoi((*k)[2], nullptr, 16));
  }
  std::set<std::pair<int, int>> read;
  for (const int vendor : {0x046D, 0x256F}) {
    for (int product = 0; product < 0x10000; ++product) {
      const auto v = static_cast<std::uint16_t>(vendor);
      const auto p = static_cast<std::uint16_t>(product);
      if (spacemouse::is_spacemouse(v, p) && !spacemouse::is_receiver(v, p)) {
        read.emplace(vendor, product);
      }
    }
  }
  CHECK(read.size() > 10);
  CHECK(named == read);
}

TEST_CASE("no rule gives a device to whoever sits at the machine") {
  std::string text = std::regex_replace(rules(), std::regex("#[^\n]*"), "");
  CHECK(text.find("uaccess") == std::string::npos);
  CHECK(text.find("MODE=\"0660\"") != std::string::npos);
}

}  // namespace hapticd
