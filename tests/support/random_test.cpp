// The generator against the published sequence of SplitMix64, and the ranges of what is derived
// from it.
#include "tests/support/random.h"
#include "tests/support/within.h"

#include <doctest/doctest.h>

#include <algorithm>

namespace {

using hapticd::test::SplitMix64;

}  // namespace

TEST_CASE("SplitMix64 gives the published sequence of seed 1234567") {
  // Reference values of the public-domain splitmix64.c (Vigna 2015), as listed by Rosetta Code
  // "Pseudo-random numbers/Splitmix64".
  SplitMix64 random(1234567);
  CHECK(random.next() == 6457827717110365317U);
  CHECK(random.next() == 3203168211198807973U);
  CHECK(random.next() == 9817491932198370423U);
  CHECK(random.next() == 4593380528125082431U);
  CHECK(random.next() == 16408922859458223821U);
}

TEST_CASE("uniform numbers fill their range and no more") {
  SplitMix64 random(1);
  double lowest = 1.0;
  double highest = 0.0;
  for (int i = 0; i < 10000; ++i) {
    const double value = random.uniform();
    lowest = std::min(lowest, value);
    highest = std::max(highest, value);
    const double in_range = random.uniform(-2.0, 3.0);
    REQUIRE(in_range >= -2.0);
    REQUIRE(in_range <= 3.0);
    REQUIRE(random.below(7) < 7);
  }
  CHECK(lowest >= 0.0);
  CHECK(highest < 1.0);
  // 10000 draws leave a gap of 0.002 at an end with probability exp(-20).
  CHECK(lowest < 0.002);
  CHECK(highest > 0.998);
}

TEST_CASE("directions have unit length and no preferred side") {
  SplitMix64 random(2);
  std::array<double, 3> mean{};
  constexpr int kCount = 10000;
  for (int i = 0; i < kCount; ++i) {
    const std::array<double, 3> direction = random.direction();
    double length_squared = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      mean[axis] += direction[axis] / kCount;
      length_squared += direction[axis] * direction[axis];
    }
    REQUIRE(length_squared == hapticd::test::within(1.0, 1e-14));
  }
  // The standard deviation of a component's mean is 1 / sqrt(3 * 10000) = 0.0058; five of them.
  for (const double component : mean) CHECK(std::abs(component) < 0.029);
}
