// Lengths with units, as they are written on the command line. Truth: the same numbers in metres.
#include "server/model/length.h"
#include "tests/support/within.h"

#include <doctest/doctest.h>

#include <stdexcept>

namespace hapticd::test {

TEST_CASE("lengths are read in every unit, and in metres without one") {
  CHECK(parse_length("250um") == within(250e-6, 1e-15));
  CHECK(parse_length("0.25mm") == within(250e-6, 1e-15));
  CHECK(parse_length("2cm") == within(0.02, 1e-15));
  CHECK(parse_length("1.22m") == 1.22);
  CHECK(parse_length("1e-3") == 1e-3);
  CHECK(parse_length("1in") == within(0.0254, 1e-15));
  CHECK(parse_length("-3mm") == within(-3e-3, 1e-15));
  CHECK(parse_length("0um") == 0.0);
}

TEST_CASE("what is no length is refused with its text") {
  for (const char* bad : {"", "um", "250 um", "250ft", "1e999m", "nan", "inf", "0x10", "1,5mm",
                          "5mmm", "250um ", "--3"}) {
    CAPTURE(bad);
    CHECK_THROWS_AS(static_cast<void>(parse_length(bad)), std::invalid_argument);
  }
}

TEST_CASE("a decimal comma is refused with the number that was meant") {
  CHECK_THROWS_WITH_AS(static_cast<void>(parse_length("1,5mm")),
                       "'1,5mm' has a comma. Write 1.5mm, with a point.", std::invalid_argument);
  // May be thousands.
  CHECK_THROWS_WITH_AS(static_cast<void>(parse_length("1,500um")),
                       "'1,500um' has a comma. Give a number without commas.",
                       std::invalid_argument);
}

TEST_CASE("lengths are written in the unit that reads best") {
  CHECK(format_length(250e-6) == "250 um");
  CHECK(format_length(0.9999e-3) == "1 mm");
  CHECK(format_length(1.234e-3) == "1.23 mm");
  CHECK(format_length(1.22) == "1.22 m");
  CHECK(format_length(0.0) == "0 um");
  CHECK(format_length(-2e-6) == "-2 um");
}

}  // namespace hapticd::test
