// Whole numbers on a command line. Truth: the digits that a number was printed with.
#include "proto/hints/whole_number_option.h"

#include <doctest/doctest.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "tests/proto/hints/typed_number.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::hints::test {
namespace {

using hapticd::test::scaled;
using hapticd::test::SplitMix64;

constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();

/// What `text` is read as, between `lowest` and `highest`; none: it is refused, and `fault` says
/// why.
std::optional<std::uint64_t> read(const std::string& text, std::uint64_t lowest,
                                  std::uint64_t highest, std::string& fault) {
  CLI::App app;
  std::uint64_t value = 0;
  takes_whole_number(app.add_option("--number", value), lowest, highest);
  fault = fault_of_typed(app, text);
  if (!fault.empty()) return std::nullopt;
  return value;
}

TEST_CASE("a whole number in digits is read, whatever noughts are before it") {
  std::string fault;
  CHECK(read("0", 0, kMost, fault) == 0U);
  CHECK(read("18446744073709551615", 0, kMost, fault) == kMost);
  CHECK(read("010", 0, kMost, fault) == 10U);
  CHECK(read("+7", 0, kMost, fault) == 7U);
  const std::uint64_t seed = hapticd::test::fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int k = 0; k < scaled(1'000); ++k) {
    const std::uint64_t number = random.next() >> (random.next() % 64);
    CHECK(read(std::to_string(number), 0, kMost, fault) == number);
  }
}

TEST_CASE("what is no whole number, or out of range, is refused with the range") {
  for (const char* text : {"-1", "99999999999999999999999", "18446744073709551616", "1.5", "1e3",
                           "1,5", "", " 1", "1 ", "0x10", "++1", "+-1", "one", "1s"}) {
    CAPTURE(text);
    std::string fault;
    CHECK(!read(text, 0, kMost, fault));
    CHECK(fault == "--number: '" + std::string(text) +
                       "' is not a whole number from 0 to 18446744073709551615.");
  }
  std::string fault;
  CHECK(!read("0", 1, 31, fault));
  CHECK(!read("32", 1, 31, fault));
  CHECK(fault == "--number: '32' is not a whole number from 1 to 31.");
  CHECK(read("31", 1, 31, fault) == 31U);
}

}  // namespace
}  // namespace hapticd::hints::test
