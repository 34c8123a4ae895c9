// PROFILE.md tells the truth: its worked reports and descriptors are those that the tests check the
// code by.
#include "tests/device/hid/worked_reports.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "device/hid/report_descriptor.h"

namespace hapticd::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// The blocks fenced by "```hex NAME" of the specification.
std::map<std::string, Bytes> printed_bytes() {
  std::ifstream file(HAPTICD_SOURCE_DIR "/device/hid/PROFILE.md");
  REQUIRE(file);
  const std::string fence = "```hex ";
  std::map<std::string, Bytes> blocks;
  std::string line;
  while (std::getline(file, line)) {
    if (line.compare(0, fence.size(), fence) != 0) continue;
    Bytes& bytes = blocks[line.substr(fence.size())];
    while (std::getline(file, line) && line != "```") {
      std::istringstream words(line);
      std::string word;
      while (words >> word) {
        REQUIRE(word.size() == 2);
        bytes.push_back(static_cast<std::uint8_t>(std::strtoul(word.c_str(), nullptr, 16)));
      }
    }
  }
  return blocks;
}

template <std::size_t Count>
Bytes bytes_of(const std::array<std::uint8_t, Count>& bytes) {
  return {bytes.begin(), bytes.end()};
}

TEST_CASE("the bytes printed in the specification are those of the tests and of the code") {
  const auto printed = printed_bytes();
  CHECK(printed.size() == 8);
  CHECK(printed.at("state") == bytes_of(kStateBytes));
  CHECK(printed.at("command") == bytes_of(kCommandBytes));
  CHECK(printed.at("affine") == bytes_of(kAffineBytes));
  CHECK(printed.at("capabilities") == bytes_of(kCapabilitiesBytes));
  CHECK(printed.at("config") == bytes_of(kConfigBytes));
  CHECK(printed.at("calibration") == bytes_of(kCalibrationBytes));
  CHECK(printed.at("descriptor") == bytes_of(hid::kPlainDescriptor));
  CHECK(printed.at("affine descriptor") == bytes_of(hid::kAffineDescriptor));
}

}  // namespace
}  // namespace hapticd::test
