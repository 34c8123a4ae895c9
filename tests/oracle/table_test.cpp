// Tables: numbers keep their bits, and no name breaks a line.
#include "tests/oracle/table.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <limits>

namespace hapticd::test {

TEST_CASE("a double in a table is read back with the same bits") {
  for (const double value : {0.1, 1.0 / 3.0, -2.5e-308, 1e300, 5e-324, 123456789.123456789}) {
    CHECK(std::strtod(exact_text(value).c_str(), nullptr) == value);
  }
}

TEST_CASE("a name with commas and quotes stays one column") {
  Table table({"tick", "gap of a, \"b\""});
  table << std::uint64_t{18446744073709551615U} << 0.5;
  table.end_row();
  CHECK(table.text() == "tick,\"gap of a, \"\"b\"\"\"\n18446744073709551615,0.5\n");
}

TEST_CASE("a file that cannot be written is named, with a remedy") {
  std::string said;
  try {
    write_output("/nowhere/at/all.csv", "x");
  } catch (const std::runtime_error& error) {
    said = error.what();
  }
  CHECK(said.find("/nowhere/at/all.csv: cannot be written") != std::string::npos);
  CHECK(said.find("--output") != std::string::npos);
}

}  // namespace hapticd::test
