// Rotation vectors against Rodrigues' formula and libm in long double.
#include "core/math/rotation.h"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <initializer_list>

#include "core/math/elementary.h"
#include "core/math/pose.h"
#include "tests/core/math/reference_rotation.h"
#include "tests/support/no_heap.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace {

using namespace hapticd;
using namespace hapticd::test;

/// What rounding the components of a unit quaternion once and a few operations may cost, rad.
constexpr Real kRounding = 1e-15L;

Quaternion negated(const Quaternion& q) { return {-q.w(), -q.x(), -q.y(), -q.z()}; }

Vector3 scaled_axis(const LongVector3& axis, Real angle) {
  return to_vector3({axis[0] * angle, axis[1] * angle, axis[2] * angle});
}

bool same_bits(const Vector3& a, const Vector3& b) {
  bool same = true;
  for (int i = 0; i < 3; ++i) {
    same = same && std::bit_cast<std::uint64_t>(a[i]) == std::bit_cast<std::uint64_t>(b[i]);
  }
  return same;
}

/// Angles where a formula changes or would lose digits, up to a half turn.
constexpr std::initializer_list<double> kHardAngles = {
    0.0,    1e-320, 1e-300, 1e-160, 1e-154, 1e-20, 1e-9, 7.4e-9,     7.46e-9,     1.49e-8,
    1.5e-8, 1e-6,   1e-4,   0.1,    1.0,    1.5,   3.0,  kPi - 1e-6, kPi - 1e-12, kPi};

}  // namespace

TEST_CASE("the exponential is the rotation of Rodrigues' formula at any angle") {
  SplitMix64 random(201);
  Real worst = 0;
  Real worst_length = 0;
  const auto compare = [&](double angle) {
    const LongVector3 axis = random_axis(random);
    const Vector3 phi = scaled_axis(axis, Real(angle));
    const Quaternion q = exp_rotation(phi);
    // The reference turns by the rounded phi: at 1e4 rad its rounding is a rotation too.
    const LongVector3 rounded = to_long(phi);
    const Real true_angle = length(rounded);
    LongVector3 true_axis = axis;
    if (true_angle > 0) {
      true_axis = {rounded[0] / true_angle, rounded[1] / true_angle, rounded[2] / true_angle};
    }
    worst = fmaxl(worst, distance(matrix_of(q), rodrigues(true_axis, true_angle)) /
                             fmaxl(1, true_angle / Real(kPi)));
    worst_length = fmaxl(worst_length, fabsl(length(q) - 1));
  };
  for (const double angle : kHardAngles) compare(angle);
  for (const double angle : {kPi + 1e-6, 4.0, 2 * kPi - 1e-9, 2 * kPi, 7.0, 1e4}) compare(angle);
  const std::int64_t count = scaled(500'000);
  for (std::int64_t i = 0; i < count; ++i) compare(random.uniform(0.0, 10.0));
  CHECK(worst <= kRounding);
  CHECK(worst_length <= 5e-16L);
}

TEST_CASE("the logarithm returns angle times axis, exact to rounding from 0 to pi") {
  SplitMix64 random(202);
  Real worst = 0;
  const auto compare = [&](double given_angle) {
    const Real angle = Real(given_angle);
    const LongVector3 axis = random_axis(random);
    const Vector3 phi = log_rotation(reference_quaternion(axis, angle));
    const LongVector3 truth{axis[0] * angle, axis[1] * angle, axis[2] * angle};
    const Real error = distance(to_long(phi), truth);
    // Small rotations keep their digits: the error is relative to the angle, or the last bit of a
    // denormal.
    worst = fmaxl(worst, (error - 2e-323L) / fmaxl(angle, 1e-323L));
  };
  for (const double angle : kHardAngles) compare(angle);
  const std::int64_t count = scaled(500'000);
  for (std::int64_t i = 0; i < count; ++i) {
    compare(random.uniform(0.0, kPi));
    compare(std::exp2(random.uniform(-1000.0, 1.0)));
  }
  CHECK(worst <= kRounding);
}

TEST_CASE("the logarithm of a rotation just past pi is the short way round") {
  SplitMix64 random(203);
  for (const double beyond : {1e-15, 1e-12, 1e-6, 1e-3, 1.0}) {
    const LongVector3 axis = random_axis(random);
    const Real angle = 3.14159265358979323846264338327950288L + Real(beyond);
    const Vector3 phi = log_rotation(reference_quaternion(axis, angle));
    const Real short_way = angle - 6.28318530717958647692528676655900577L;
    CHECK(distance(to_long(phi), {axis[0] * short_way, axis[1] * short_way, axis[2] * short_way}) <=
          3 * kRounding);
  }
}

TEST_CASE("the logarithm of the identity is zero and of a half turn has the axis as given") {
  for (const double w : {1.0, -1.0}) {
    for (const double zero : {0.0, -0.0}) {
      const Vector3 phi = log_rotation({w, zero, zero, zero});
      CHECK(phi == Vector3(0.0, 0.0, 0.0));
    }
  }
  CHECK(log_rotation({0.0, 0.0, 1.0, 0.0}) == Vector3(0.0, kPi, 0.0));
  CHECK(log_rotation({0.0, 0.0, -1.0, 0.0}) == Vector3(0.0, -kPi, 0.0));
  CHECK(log_rotation({-0.0, 1.0, 0.0, 0.0}) == Vector3(kPi, 0.0, 0.0));
  const Quaternion unit = exp_rotation({0.0, 0.0, 0.0});
  CHECK(unit.w() == 1.0);
  CHECK(unit.vec() == Vector3(0.0, 0.0, 0.0));
}

TEST_CASE("a quaternion and its negative have the same logarithm to the bit") {
  SplitMix64 random(204);
  bool same = true;
  const auto compare = [&](const Quaternion& q) {
    const Vector3 reference = scaled_axis(random_axis(random), Real(random.uniform(0.0, 4.0)));
    same = same && same_bits(log_rotation(q), log_rotation(negated(q))) &&
           same_bits(log_rotation_near(q, reference, 5.0),
                     log_rotation_near(negated(q), reference, 5.0));
  };
  for (const double angle : {1e-300, 1e-9, 1e-8, 1.0, kPi - 1e-6, kPi - 1e-15, kPi + 1e-6, 6.0}) {
    compare(reference_quaternion(random_axis(random), Real(angle)));
  }
  const std::int64_t count = scaled(200'000);
  for (std::int64_t i = 0; i < count; ++i) {
    compare(reference_quaternion(random_axis(random), Real(random.uniform(-7.0, 7.0))));
  }
  CHECK(same);
}

TEST_CASE("the logarithm undoes the exponential up to a half turn") {
  SplitMix64 random(205);
  Real worst = 0;
  const auto compare = [&](double angle) {
    const Vector3 phi = scaled_axis(random_axis(random), Real(angle));
    worst = fmaxl(worst, distance(to_long(log_rotation(exp_rotation(phi))), to_long(phi)));
  };
  for (const double angle : kHardAngles) {
    if (angle < kPi) compare(angle);
  }
  const std::int64_t count = scaled(500'000);
  for (std::int64_t i = 0; i < count; ++i) compare(random.uniform(0.0, kPi - 1e-14));
  CHECK(worst <= 2 * kRounding);
}

TEST_CASE("the logarithm does not depend on the length of the quaternion") {
  SplitMix64 random(206);
  Real worst = 0;
  for (int i = 0; i < 1000; ++i) {
    const Quaternion q = reference_quaternion(random_axis(random), Real(random.uniform(0.0, kPi)));
    const double scale = random.uniform(0.5, 2.0);
    const Quaternion longer{q.w() * scale, q.x() * scale, q.y() * scale, q.z() * scale};
    worst = fmaxl(worst, distance(to_long(log_rotation(longer)), to_long(log_rotation(q))));
  }
  CHECK(worst <= 2 * kRounding);
}

TEST_CASE(
    "the latched logarithm runs continuously through pi in both directions, whatever the sign of "
    "q") {
  SplitMix64 random(207);
  for (const Real direction : {1.0L, -1.0L}) {
    const LongVector3 axis = random_axis(random);
    // Steps of 1 mrad and, about the half turn itself, steps down to one rounding.
    Vector3 previous = scaled_axis(axis, direction * 2.8L);
    Real worst = 0;
    const auto follow = [&](Real angle) {
      Quaternion q = reference_quaternion(axis, direction * angle);
      if (random.chance(0.5)) q = negated(q);
      const Vector3 phi = log_rotation_near(q, previous, 4.0);
      const Real truth = direction * angle;
      worst =
          fmaxl(worst, distance(to_long(phi), {axis[0] * truth, axis[1] * truth, axis[2] * truth}));
      previous = phi;
    };
    const Real pi = 3.14159265358979323846264338327950288L;
    for (int i = 0; i <= 340; ++i) follow(2.8L + static_cast<Real>(i) * 1e-3L);
    for (const Real offset : {-1e-6L, -1e-12L, -1e-16L, 0.0L, 1e-16L, 1e-12L, 1e-6L})
      follow(pi + offset);
    for (int i = 0; i < 800; ++i) follow(pi + static_cast<Real>(i) * 1e-3L);
    for (int i = 800; i >= -400; --i) follow(pi + static_cast<Real>(i) * 1e-3L);
    CHECK(worst <= 3 * kRounding);
  }
}

TEST_CASE("the latched logarithm at exactly pi keeps the side of its reference") {
  const Quaternion half_turn{0.0, 1.0, 0.0, 0.0};
  for (const Quaternion& q : {half_turn, negated(half_turn)}) {
    CHECK(log_rotation_near(q, {3.0, 0.0, 0.0}, 4.0) == Vector3(kPi, 0.0, 0.0));
    CHECK(log_rotation_near(q, {-3.0, 0.0, 0.0}, 4.0) == Vector3(-kPi, 0.0, 0.0));
  }
}

TEST_CASE(
    "the latched logarithm is the principal one past the largest angle and near no rotation") {
  const LongVector3 axis{1, 0, 0};
  const Vector3 reference(3.9, 0.0, 0.0);
  CHECK(log_rotation_near(reference_quaternion(axis, 3.95L), reference, 4.0).x() > 3.9);
  const Quaternion beyond = reference_quaternion(axis, 4.05L);
  CHECK(same_bits(log_rotation_near(beyond, reference, 4.0), log_rotation(beyond)));

  const Vector3 far(6.0, 0.0, 0.0);
  CHECK(log_rotation_near({1.0, 0.0, 0.0, 0.0}, far, 6.28) == Vector3(0.0, 0.0, 0.0));
  CHECK(log_rotation_near({-1.0, 1e-300, 0.0, 0.0}, far, 6.28) == Vector3(-2e-300, 0.0, 0.0));
  const Quaternion small = reference_quaternion(axis, 0.1L);
  CHECK(same_bits(log_rotation_near(small, {0.0, 0.0, 0.0}, 4.0), log_rotation(small)));
}

TEST_CASE("1e7 compositions with renormalisation keep the length within 1e-12 and do not drift") {
  // The truth is one rotation by the sum of the angles.
  const LongVector3 axis{2.0L / 7, -3.0L / 7, 6.0L / 7};
  const Vector3 step_phi = scaled_axis(axis, 1e-3L);
  const Quaternion step = exp_rotation(step_phi);
  Quaternion q{1.0, 0.0, 0.0, 0.0};
  Real worst_length = 0;
  const std::int64_t count = scaled(10'000'000);
  for (std::int64_t i = 0; i < count; ++i) {
    q = renormalised(step * q);
    worst_length = fmaxl(worst_length, fabsl(length(q) - 1));
  }
  CHECK(worst_length < 1e-12L);

  const Real step_angle = length(to_long(step_phi));
  const LongMatrix3 truth = rodrigues(axis, step_angle * static_cast<Real>(count));
  // The step itself is known to 1e-16 rad, the sum to count times that.
  CHECK(distance(matrix_of(q), truth) < 2e-16L * static_cast<Real>(count) + kRounding);
}

TEST_CASE(
    "rotations in one sense compose as their vectors add, on the heap's account free of charge") {
  SplitMix64 random(208);
  Real worst = 0;
  const NoHeapScope scope;
  for (int i = 0; i < 10'000; ++i) {
    const LongVector3 axis = random_axis(random);
    const Real a = Real(random.uniform(-1.5, 1.5));
    const Real b = Real(random.uniform(-1.5, 1.5));
    const Quaternion both = exp_rotation(scaled_axis(axis, a)) * exp_rotation(scaled_axis(axis, b));
    const Real sum = a + b;
    worst = fmaxl(worst, distance(to_long(log_rotation(both)),
                                  {axis[0] * sum, axis[1] * sum, axis[2] * sum}));
  }
  const std::int64_t heap_calls = scope.count();
  CHECK(worst <= 2 * kRounding);
  CHECK(heap_calls == 0);
}
