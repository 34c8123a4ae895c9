// Truth: the definition, in long double: the nearest point P of the segment by search, and
// out = P + (F - P) shortened to the step.
#include "core/safety/slew_limit.h"

#include <doctest/doctest.h>

#include <cmath>

#include "tests/core/safety/hostile.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

using Long3 = Eigen::Matrix<long double, 3, 1>;

Long3 by_search(const Vector3& F_in, const Vector3& F_prev_in, long double step) {
  const Long3 F = F_in.cast<long double>();
  const Long3 F_prev = F_prev_in.cast<long double>();
  // The squared distance is convex along the segment: bisect its slope by two near samples.
  long double low = 0.0L;
  long double high = 1.0L;
  for (int k = 0; k < 70; ++k) {
    const long double middle = (low + high) / 2.0L;
    const Long3 P = middle * F_prev;
    if ((P - F).dot(F_prev) < 0.0L) {
      low = middle;
    } else {
      high = middle;
    }
  }
  const Long3 P = low * F_prev;
  const Long3 way = F - P;
  const long double size = way.norm();
  return size <= step ? F : Long3(P + way * (step / size));
}

}  // namespace

TEST_CASE("the slewed force is the one of the definition, for forces of every size and angle") {
  SplitMix64 random(11);
  for (std::int64_t i = 0; i < scaled(1'000'000); ++i) {
    const double scale = std::pow(10.0, random.uniform(-12.0, 6.0));
    const Vector3 F_prev = to_vector(random.direction()) * (scale * random.uniform());
    Vector3 F = to_vector(random.direction()) * (scale * random.uniform());
    if (random.chance(0.3)) F = F_prev * random.uniform(-1.5, 1.5) + F * 1e-6;
    const double step = scale * random.uniform(0.0, 0.5);
    bool limited = false;
    const Vector3 out = slewed(F, F_prev, step, limited);
    const Long3 truth = by_search(F, F_prev, step);
    if (!((out.cast<long double>() - truth).norm() <= 1e-14L * scale)) FAIL("wrong in case " << i);
    if (!limited && !(out == F)) FAIL("changed in silence in case " << i);
  }
}

TEST_CASE("anything on the way from the last force to zero is reached in no time") {
  SplitMix64 random(12);
  for (std::int64_t i = 0; i < scaled(100'000); ++i) {
    const Vector3 F_prev = to_vector(random.direction()) * random.uniform(0.0, 100.0);
    bool limited = false;
    const Vector3 F = F_prev * random.uniform();
    REQUIRE((slewed(F, F_prev, 0.0, limited) - F).norm() <= 1e-13);
  }
}

TEST_CASE("from denormal forces growth is measured from zero") {
  bool limited = false;
  const Vector3 out = slewed({10, 0, 0}, {1e-310, 0, 0}, 2.2, limited);
  CHECK(out.x() == doctest::Approx(2.2));
  CHECK(limited);
}

}  // namespace hapticd::test
