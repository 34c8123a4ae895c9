// What a released reader relies on stays: data/schema_v1.txt lists every message, field and enum
// value that was ever in v1, and the schema may only add to it. The first test fails after an
// addition, until its lines are appended, by hand or in tests/protocol/data by
//   print_schema | grep -vxFf schema_v1.txt >> schema_v1.txt
// The second guards readers. No line is ever taken out.
#include <doctest/doctest.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "tests/protocol/schema.h"

namespace hapticd::test {
namespace {

std::vector<std::string> frozen_lines() {
  std::ifstream file(HAPTICD_SOURCE_DIR "/tests/protocol/data/schema_v1.txt");
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty() && line.front() != '#') lines.push_back(line);
  }
  return lines;
}

TEST_CASE("the frozen schema lists everything there is") {
  const std::vector<std::string> frozen = frozen_lines();
  for (const std::string& line : schema_lines()) {
    CAPTURE(line);
    CHECK(std::count(frozen.begin(), frozen.end(), line) == 1);
  }
}

TEST_CASE("nothing of the frozen schema has been removed, renumbered, retyped or renamed") {
  const std::vector<std::string> frozen = frozen_lines();
  const std::vector<std::string> present = schema_lines();
  REQUIRE(frozen.size() > 400);
  for (const std::string& line : frozen) {
    CAPTURE(line);
    CHECK(std::count(present.begin(), present.end(), line) == 1);
  }
}

}  // namespace
}  // namespace hapticd::test
