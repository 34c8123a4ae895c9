// Numbers with units, as people write them. Truth: the same numbers as literals in the other unit.
#include "proto/hints/quantity.h"

#include <doctest/doctest.h>

#include <string>

namespace hapticd::hints::test {
namespace {

/// The value, where there is no fault.
double value_of(const char* text, const char* unit) {
  const Quantity quantity = parse_quantity(text, unit);
  CAPTURE(text);
  CHECK(quantity.fault == "");
  return quantity.value;
}

std::string fault_of(const char* text, const char* unit) {
  return parse_quantity(text, unit).fault;
}

}  // namespace

TEST_CASE("a number is in the unit that is asked for, with it or without") {
  CHECK(value_of("45", "N") == 45.0);
  CHECK(value_of("45N", "N") == 45.0);
  CHECK(value_of(" -4.5e1 N ", "N") == -45.0);
  CHECK(value_of("7", "count") == 7.0);
  CHECK(value_of("0.1", "") == 0.1);
  CHECK(value_of("+1000", "Hz") == 1000.0);
  CHECK(value_of("500", "us") == 500.0);
}

TEST_CASE("a shifted decimal point is exact to the last bit") {
  CHECK(value_of("250um", "m") == 250e-6);
  CHECK(value_of("0.34 mm", "m") == 0.34e-3);
  CHECK(value_of("190GPa", "Pa") == 190e9);
  CHECK(value_of("1.9e2GPa", "Pa") == 190e9);
  CHECK(value_of("0.1ms", "us") == 100.0);
  CHECK(value_of("1.5 kHz", "Hz") == 1500.0);
  CHECK(value_of("3 \u00b5m", "m") == 3e-6);
  CHECK(value_of("3 \u03bcm", "m") == 3e-6);
  CHECK(value_of("0e2147483647km", "m") == 0.0);
  CHECK(value_of("0e-2147483648mm", "m") == 0.0);
}

TEST_CASE("products and quotients of units are read in any order") {
  CHECK(value_of("1.2 N/mm", "N/m") == 1200.0);
  CHECK(value_of("3 s N/m", "N s/m") == 3.0);
  CHECK(value_of("0.5 N ms/mm", "N s/m") == 0.5);
  CHECK(value_of("2 g/m", "kg/m") == 2e-3);
  CHECK(value_of("180deg", "rad") == doctest::Approx(3.14159265358979));
  CHECK(value_of("90 deg/s", "rad/s") == doctest::Approx(1.5707963267949));
}

TEST_CASE("a decimal comma is refused with the right form") {
  CHECK(fault_of("45,5", "N") == "Write 45.5, with a point.");
  CHECK(fault_of("0,25mm", "m") == "Write 0.25mm, with a point.");
  CHECK(fault_of("1,2,3", "m") == "Give a number without commas.");
  CHECK(fault_of("1,000", "N") == "Give a number without commas.");
  CHECK(fault_of("0,045kN", "N") == "Write 0.045kN, with a point.");
  CHECK(fault_of("-0,125", "N") == "Write -0.125, with a point.");
  CHECK(fault_of("10,125", "N") == "Give a number without commas.");
  CHECK(fault_of("1,0000N", "N") == "Write 1.0000N, with a point.");
}

TEST_CASE("what is no number, or is in another unit, is refused in words") {
  for (const char* text :
       {"", " ", "N", "much", "nan", "inf", "1e999", "--4", "0x10", "4 5", "++4", "+-4"}) {
    CAPTURE(text);
    CHECK(!fault_of(text, "N").empty());
  }
  CHECK(fault_of("45 m", "N") == "Give it in N.");
  CHECK(fault_of("45 N/m/s", "N/m") == "Give it in N/m.");
  CHECK(fault_of("45 /", "N/m") == "Give it in N/m.");
  CHECK(fault_of("45 N", "count") == "Give a number alone; it has no unit.");
  CHECK(fault_of("1e308km", "m") == "Give a number.");
}

}  // namespace hapticd::hints::test
