// Poses against 4x4 arithmetic (a 3x3 matrix and a column) in long double.
#include "core/math/pose.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "tests/core/math/reference_rotation.h"
#include "tests/support/pose_composition.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace {

using namespace hapticd;
using namespace hapticd::test;

/// Relative to the size of the numbers: a few roundings each.
constexpr Real kRounding = 3e-15L;

/// The upper three rows of a 4x4 pose matrix.
struct LongPose {
  LongMatrix3 r{};
  LongVector3 p{};
};

LongPose to_long(const Pose& X) { return {matrix_of(X.q), test::to_long(X.p)}; }

LongVector3 sum(const LongVector3& a, const LongVector3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

LongPose product(const LongPose& a, const LongPose& b) {
  return {test::product(a.r, b.r), sum(test::product(a.r, b.p), a.p)};
}

LongPose inverse_of(const LongPose& a) {
  const LongMatrix3 r = transposed(a.r);
  const LongVector3 p = test::product(r, a.p);
  return {r, {-p[0], -p[1], -p[2]}};
}

Real error(const Pose& X, const LongPose& truth, double reach) {
  return fmaxl(distance(matrix_of(X.q), truth.r),
               distance(test::to_long(X.p), truth.p) / Real(reach));
}

}  // namespace

TEST_CASE("transform, compose and inverse agree with matrices in long double") {
  SplitMix64 random(301);
  Real worst = 0;
  const std::int64_t count = scaled(200'000);
  for (std::int64_t i = 0; i < count; ++i) {
    const double reach = std::exp2(random.uniform(-10.0, 10.0));
    const Pose X_AB = random_pose(random, reach);
    const Pose X_BC = random_pose(random, reach);
    const Vector3 p_BQ(random.uniform(-reach, reach), random.uniform(-reach, reach),
                       random.uniform(-reach, reach));
    const LongPose a = to_long(X_AB);

    const LongVector3 p_AQ = sum(test::product(a.r, test::to_long(p_BQ)), a.p);
    worst = fmaxl(worst, distance(test::to_long(transform(X_AB, p_BQ)), p_AQ) / Real(reach));
    worst = fmaxl(worst, error(compose(X_AB, X_BC), product(a, to_long(X_BC)), reach));
    worst = fmaxl(worst, error(inverse(X_AB), inverse_of(a), reach));
  }
  CHECK(worst <= kRounding);
}

TEST_CASE("a pose composed with its inverse leaves every point where it is") {
  SplitMix64 random(302);
  double worst = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const Pose X_AB = random_pose(random, 1.0);
    const Vector3 p_BQ(random.uniform(), random.uniform(), random.uniform());
    const Vector3 back = transform(inverse(X_AB), transform(X_AB, p_BQ));
    const Vector3 stayed = transform(compose(inverse(X_AB), X_AB), p_BQ);
    worst = std::fmax(worst, (back - p_BQ).cwiseAbs().maxCoeff());
    worst = std::fmax(worst, (stayed - p_BQ).cwiseAbs().maxCoeff());
  }
  CHECK(worst <= 4e-15);
}

TEST_CASE("the default pose is the identity") {
  const Vector3 p(1.0, -2.0, 3.0);
  CHECK(transform(Pose{}, p) == p);
}

TEST_CASE("renormalising gives the same rotation with length 1 to rounding") {
  SplitMix64 random(303);
  Real worst_length = 0;
  Real worst_direction = 0;
  for (int i = 0; i < 10'000; ++i) {
    const Quaternion q = reference_quaternion(random_axis(random), Real(random.uniform(-7.0, 7.0)));
    const double scale = std::exp2(random.uniform(-100.0, 100.0));
    const Quaternion result =
        renormalised({q.w() * scale, q.x() * scale, q.y() * scale, q.z() * scale});
    worst_length = fmaxl(worst_length, fabsl(length(result) - 1));
    worst_direction = fmaxl(worst_direction, distance(matrix_of(result), matrix_of(q)));
  }
  CHECK(worst_length <= 4e-16L);
  CHECK(worst_direction <= 2e-15L);
}

TEST_CASE("plain arrays carry vectors and quaternions unchanged, the quaternion with w first") {
  const Array4 q = to_array(Quaternion(0.5, -0.5, 0.1, 0.7));
  CHECK(q == Array4{0.5, -0.5, 0.1, 0.7});
  CHECK(to_array(to_quaternion(q)) == q);
  const Array3 v{1.0, 2.0, 3.0};
  CHECK(to_vector(v) == Vector3(1.0, 2.0, 3.0));
  CHECK(to_array(to_vector(v)) == v);
}
