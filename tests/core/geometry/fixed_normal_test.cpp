// The way out for a centre that lies exactly on an axis: unit, normal, and always the same.
#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <limits>

#include "core/geometry/closest_point.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

bool same_bits(const Vector3& a, const Vector3& b) {
  bool same = true;
  for (int k = 0; k < 3; ++k) {
    same = same &&
           std::bit_cast<std::uint64_t>(a[k] + 0.0) == std::bit_cast<std::uint64_t>(b[k] + 0.0);
  }
  return same;
}

}  // namespace

TEST_CASE("the fixed normal is a unit vector normal to its axis, of any direction and length") {
  SplitMix64 random(1);
  for (std::int64_t i = 0; i < scaled(300'000); ++i) {
    Vector3 axis = random_vector(random, 1.0);
    // Nearly along a coordinate axis, or in a coordinate plane, where a careless choice
    // degenerates.
    if (i % 3 == 0) axis[static_cast<Eigen::Index>(random.below(3))] *= 1e-12;
    if (i % 5 == 0) axis[static_cast<Eigen::Index>(random.below(3))] = 0.0;
    if (axis.isZero()) continue;
    axis *= std::pow(10.0, random.uniform(-140.0, 140.0));
    const Vector3 n = fixed_normal(axis);
    REQUIRE(std::abs(n.norm() - 1.0) <= 4e-16);
    REQUIRE(std::abs(n.dot(axis / length(axis))) <= 4e-16);
  }
}

TEST_CASE("both directions of an axis have the same normal to the bit") {
  SplitMix64 random(2);
  for (std::int64_t i = 0; i < scaled(100'000); ++i) {
    const Vector3 axis = random_vector(random, 1.0);
    const Vector3 reversed = -axis;
    REQUIRE(same_bits(fixed_normal(axis), fixed_normal(reversed)));
  }
}

TEST_CASE("the normal depends on the line of the axis, not on its length") {
  SplitMix64 random(3);
  for (std::int64_t i = 0; i < scaled(100'000); ++i) {
    const Vector3 axis = random_vector(random, 1.0);
    const Vector3 n = fixed_normal(axis);
    REQUIRE(same_bits(n, fixed_normal(axis * 0x1p-300)));
    REQUIRE(same_bits(n, fixed_normal(axis * 0x1p300)));
    REQUIRE((n - fixed_normal(axis * random.uniform(0.1, 10.0))).norm() <= 1e-15);
  }
}

TEST_CASE("strings along the coordinate axes push out upwards, a vertical one along z") {
  for (const double L : {1e-6, 1.0, 1e7, -1.0}) {
    CHECK(fixed_normal({L, 0, 0}) == Vector3(0, 1, 0));
    CHECK(fixed_normal({0, 0, L}) == Vector3(0, 1, 0));
    CHECK(fixed_normal({0, L, 0}) == Vector3(0, 0, 1));
  }
}

TEST_CASE("an axis that vanishes has the normal +y") {
  for (const double L : {0.0, -0.0, 1e-320, -1e-200, 0.5 * kMinLength}) {
    CHECK(fixed_normal({L, L, -L}) == Vector3(0, 1, 0));
    CHECK(fixed_normal({0, 0, L}) == Vector3(0, 1, 0));
  }
}

TEST_CASE("an offset gives its own direction down to the smallest length and the fixed one below") {
  const Vector3 axis(0.3, -0.2, 0.9);
  for (const double d : {kMinLength, 1e-149, 1e-9, 1.0, 1e150}) {
    const Vector3 n = direction_or_fallback({0.6 * d, 0.0, -0.8 * d}, d, axis);
    CHECK((n - Vector3(0.6, 0.0, -0.8)).norm() <= 4e-16);
  }
  for (const double d : {0.0, 1e-320, 1e-200, 0.999 * kMinLength}) {
    const Vector3 n = direction_or_fallback({0.6 * d, 0.0, -0.8 * d}, d, axis);
    CHECK(same_bits(n, fixed_normal(axis)));
  }
  CHECK(direction_or_fallback({0, 0, 0}, 0.0, {0, 0, 0}) == Vector3(0, 1, 0));
}

TEST_CASE("a vector's length is exact to rounding over the whole range of lengths") {
  SplitMix64 random(4);
  for (std::int64_t i = 0; i < scaled(100'000); ++i) {
    const Vector3 v = random_vector(random, 1.0) * std::pow(10.0, random.uniform(-149.0, 149.0));
    long double square = 0;
    for (int k = 0; k < 3; ++k) square += static_cast<long double>(v[k]) * v[k];
    const long double truth = std::sqrt(square);
    REQUIRE(std::abs(length(v) - truth) <= 4e-16L * truth);
  }
}

}  // namespace hapticd::test
