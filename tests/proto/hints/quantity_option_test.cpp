// Numbers with units on a command line. Truth: what SI's prefixes say.
#include "proto/hints/quantity_option.h"

#include <doctest/doctest.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "tests/proto/hints/typed_number.h"

namespace hapticd::hints::test {
namespace {

/// What `text` is read as, in `unit` and between 0 and `most`; none: it is refused, and `fault`
/// says why.
std::optional<double> read(const std::string& text, const char* unit, double most,
                           std::string& fault) {
  CLI::App app;
  double value = 0.0;
  CLI::Option* option = app.add_option("--number", value)->check(CLI::Range(-80.0, most));
  takes_unit(option, unit);
  fault = fault_of_typed(app, text);
  if (!fault.empty()) return std::nullopt;
  return value;
}

TEST_CASE("a number may have the unit that is asked for, another of its kind, or none") {
  std::string fault;
  CHECK(read("0.25", "s", 1.0, fault) == 0.25);
  CHECK(read("0.25s", "s", 1.0, fault) == 0.25);
  CHECK(read("250ms", "s", 1.0, fault) == 0.25);
  CHECK(read("250 us", "s", 1.0, fault) == 250e-6);
  CHECK(read("0.012s", "ms", 1000.0, fault) == 12.0);
  CHECK(read("44.1kHz", "Hz", 192000.0, fault) == 44100.0);
  CHECK(read("-6dB", "dB", 40.0, fault) == -6.0);
  CHECK(read("-6", "dB", 40.0, fault) == -6.0);
  CHECK(read("0.1", "s", 1.0, fault) == 0.1);  // to the last bit
}

TEST_CASE("a bound is one in the unit that is asked for") {
  std::string fault;
  CHECK(!read("2000ms", "s", 1.0, fault));
  CHECK(fault.find("Value 2 not in range") != std::string::npos);
  CHECK(!read("2", "s", 1.0, fault));
}

TEST_CASE(
    "what is in another unit, no number or has a decimal comma is refused with what is right") {
  std::string fault;
  CHECK(!read("20N", "s", 1.0, fault));
  CHECK(fault == "--number: 20N cannot be read. Give it in s.");
  CHECK(!read("soon", "s", 1.0, fault));
  CHECK(fault == "--number: soon cannot be read. Give a number.");
  CHECK(!read("0,05", "s", 1.0, fault));
  CHECK(fault == "--number: Write 0.05, with a point.");
  CHECK(!read("3N", "dB", 40.0, fault));
  CHECK(fault == "--number: 3N cannot be read. Give a number, in dB.");
}

}  // namespace
}  // namespace hapticd::hints::test
