// Rows of a table of poses. Truth: the cases; of norms, long double.
#include "clients/ctl/pose_row.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <string>

#include "clients/ctl/connection.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {

using namespace hapticd::ctl;

namespace {

/// What is said of a row that is refused; "": it is none, or a good one.
std::string fault_of(const std::string& row, const RowPlace& place = {"", 2}) {
  try {
    (void)parse_pose(row, place);
  } catch (const Failure& failure) {
    CHECK(failure.exit_code() == kRefused);
    return failure.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a row is a position, or a position and a quaternion, in metres or with units") {
  const auto pose = parse_pose("0.1, -2e-3,3", {"", 5});
  REQUIRE(pose.has_value());
  CHECK(pose->p_m(1) == -2e-3);
  CHECK(pose->q(0) == 1.0);
  CHECK(pose->q(3) == 0.0);
  CHECK(parse_pose("1\t2 3  0.5 0.5 0.5 -0.5\r", {"", 1})->q(3) == -0.5);
  const auto with_units = parse_pose("100mm,2um,-0.3cm", {"", 1});
  REQUIRE(with_units.has_value());
  CHECK(with_units->p_m(0) == 0.1);
  CHECK(with_units->p_m(1) == 2e-6);
  CHECK(with_units->p_m(2) == -0.003);
}

TEST_CASE("empty lines, comments and the heading are no rows") {
  for (const char* line : {"x,y,z", "x y z qw qx qy qz", "time, x"}) {
    CAPTURE(line);
    CHECK(!parse_pose(line, {"", 1}).has_value());
    CHECK(!fault_of(line).empty());
  }
  CHECK(!parse_pose("", {"", 3}).has_value());
  CHECK(!parse_pose(" \r", {"", 3}).has_value());
  CHECK(!parse_pose("  # rest", {"", 3}).has_value());
  for (const char* line : {"abc", "nan,0,0", "NaN,NaN,NaN", "inf 0 0", "infinity,1,2"}) {
    CAPTURE(line);
    CHECK(fault_of(line, {"", 1}).starts_with("line 1: "));
  }
}

TEST_CASE("what is no pose is refused with its place and what is right") {
  for (const char* bad :
       {"1,2", "1,2,3,4", "1,2,3x", "1 2 3 4 5 6 7 8", "nan,0,0", "0,inf,0", "0,0,1e999", "1N,0,0",
        "0,0,0,0,0,0,0", "0,0,0,2.1,0,0,0", "0,0,0,nan,0,0,1", "0,0,0,1m,0,0,0"}) {
    CAPTURE(bad);
    CHECK(fault_of(bad).starts_with("line 2: "));
    CHECK(fault_of(bad, {"path.csv", 7}).starts_with("path.csv:7: "));
    CHECK(fault_of(bad).ends_with("all are finite."));
  }
  CHECK(fault_of("0,0,0,0,0,0,0").find("outside [0.5, 2]") != std::string::npos);
  CHECK(fault_of(std::string(10'000, 'x')).size() < 300);
}

TEST_CASE("a quaternion is taken where its norm is from 0.5 to 2") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int k = 0; k < scaled(2'000); ++k) {
    std::array<double, 4> q{};
    long double square = 0.0L;
    std::string row = "0,0,0";
    for (double& each : q) {
      each = static_cast<double>(random.next() % 3001) / 1000.0 - 1.5;
      const std::string text = std::to_string(each);
      each = std::stod(text);
      square += static_cast<long double>(each) * each;
      row += "," + text;
    }
    // Nearer than rounding may take it either side.
    if (std::abs(square - 0.25L) < 1e-9L || std::abs(square - 4.0L) < 1e-9L) continue;
    CAPTURE(row);
    CHECK(fault_of(row).empty() == (square > 0.25L && square < 4.0L));
  }
}

}  // namespace hapticd::test
