// Wrenches and twists by what is physical about them: power and motion do not depend on the point
// of reference.
#include "core/math/wrench.h"

#include <doctest/doctest.h>

#include <cmath>

#include "core/math/pose.h"
#include "tests/core/math/reference_rotation.h"
#include "tests/support/random.h"

namespace {

using namespace hapticd;
using namespace hapticd::test;

Vector3 random_vector(SplitMix64& random) {
  return {random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)};
}

}  // namespace

TEST_CASE("the power of a wrench on a twist does not depend on the point both refer to") {
  SplitMix64 random(401);
  double worst = 0.0;
  for (int i = 0; i < 10'000; ++i) {
    const Wrench F_P{random_vector(random), random_vector(random)};
    const Twist V_P{random_vector(random), random_vector(random)};
    const Vector3 p_QP = random_vector(random);
    const Twist V_Q{point_velocity(V_P, -p_QP), V_P.w};
    worst = std::fmax(worst, std::abs(power(shift(F_P, p_QP), V_Q) - power(F_P, V_P)));
  }
  CHECK(worst <= 1e-14);
}

TEST_CASE("a force of 2 N along y at 3 m along x has 6 N m about z at the origin") {
  const Wrench at_point{{0.0, 2.0, 0.0}, {0.0, 0.0, 0.0}};
  const Wrench at_origin = shift(at_point, {3.0, 0.0, 0.0});
  CHECK(at_origin.f == Vector3(0.0, 2.0, 0.0));
  CHECK(at_origin.t == Vector3(0.0, 0.0, 6.0));
  CHECK(shift(at_origin, {-3.0, 0.0, 0.0}).t == Vector3(0.0, 0.0, 0.0));
}

TEST_CASE("the velocity of a point is the derivative of its place on the moving body") {
  SplitMix64 random(402);
  const Real h = 1e-5L;  // s; the symmetric difference errs by h^2 |w|^3 / 6
  Real worst = 0;
  for (int i = 0; i < 1000; ++i) {
    const Twist V_P{random_vector(random), random_vector(random)};
    const Vector3 p_PQ = random_vector(random);
    const LongVector3 w = to_long(V_P.w);
    const Real rate = length(w);
    const LongVector3 axis{w[0] / rate, w[1] / rate, w[2] / rate};
    const LongVector3 after = product(rodrigues(axis, rate * h), to_long(p_PQ));
    const LongVector3 before = product(rodrigues(axis, -rate * h), to_long(p_PQ));
    LongVector3 truth = to_long(V_P.v);
    for (std::size_t k = 0; k < 3; ++k) truth[k] += (after[k] - before[k]) / (2 * h);
    worst = fmaxl(worst, distance(to_long(point_velocity(V_P, p_PQ)), truth));
  }
  CHECK(worst <= 1e-9L);
}
