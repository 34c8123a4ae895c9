// Truth: the definition, |out| <= limit, out parallel to in, unchanged below the limit, zero for
// anything non-finite.
#include "core/safety/wrench_limit.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

Vector3 random_vector(SplitMix64& random) {
  const double size = std::pow(10.0, random.uniform(-300.0, 300.0));
  return to_vector(random.direction()) * size;
}

}  // namespace

TEST_CASE(
    "the limited wrench never exceeds its limits and keeps its directions, from 1e-300 to 1e300") {
  SplitMix64 random(7);
  const WrenchLimits limits;
  for (std::int64_t i = 0; i < scaled(1'000'000); ++i) {
    const Wrench in{random_vector(random), random_vector(random)};
    const Wrench out = limited(in, limits);
    REQUIRE(out.f.norm() <= limits.force * (1 + 1e-15));
    REQUIRE(out.t.norm() <= limits.torque * (1 + 1e-15));
    REQUIRE(out.f.stableNormalized().dot(in.f.stableNormalized()) > 1 - 1e-12);
    REQUIRE(out.t.stableNormalized().dot(in.t.stableNormalized()) > 1 - 1e-12);
  }
}

TEST_CASE("a wrench below its limits passes unchanged to the last bits") {
  const Wrench in{{1.0, -2.0, 3.0}, {0.1, 0.2, -0.3}};
  const Wrench out = limited(in, WrenchLimits{});
  CHECK((out.f - in.f).norm() <= 1e-15);
  CHECK((out.t - in.t).norm() <= 1e-16);
}

TEST_CASE("a wrench with one non-finite component becomes the zero wrench") {
  const double bad[] = {
      std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::signaling_NaN(),
      std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const double value : bad) {
    for (Eigen::Index k = 0; k < 6; ++k) {
      Wrench in{{1, 2, 3}, {0.1, 0.2, 0.3}};
      (k < 3 ? in.f[k] : in.t[k - 3]) = value;
      const Wrench out = limited(in, WrenchLimits{});
      CHECK(out.f == Vector3::Zero());
      CHECK(out.t == Vector3::Zero());
    }
  }
}

TEST_CASE("force and torque are limited independently, and a limit of zero silences one") {
  const Wrench out = limited({{3, 0, 4}, {0, 0.1, 0}}, {.force = 0.0, .torque = 0.515});
  CHECK(out.f == Vector3::Zero());
  CHECK((out.t - Vector3(0, 0.1, 0)).norm() <= 1e-17);
}

}  // namespace hapticd::test
