// The count of a random test follows the scale and never falls below one.
#include "tests/support/scale.h"

#include <doctest/doctest.h>

TEST_CASE("the scale lies above 0 and up to 1") {
  CHECK(hapticd::test::test_scale() > 0.0);
  CHECK(hapticd::test::test_scale() <= 1.0);
}

TEST_CASE("a scaled count is the share of the full count, at least one") {
  CHECK(hapticd::test::scaled(1) == 1);
  const double expected = 1e6 * hapticd::test::test_scale();
  const auto count = static_cast<double>(hapticd::test::scaled(1000000));
  CHECK(count <= expected);
  CHECK(count > expected - 1.0);
}
