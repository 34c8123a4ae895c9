// The nearest point of a segment against its definition in long double: every length and ratio, the
// ends, the seam between cylinder and cap, the limits of the number range.
#include "core/geometry/closest_point.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support/contact_scenes.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

using Real = long double;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// The definition, in long double.
struct Truth {
  Real lambda;
  std::array<Real, 3> offset;
  Real distance;
};

Truth truth_of(const Vector3& p_A, const Vector3& p_B, const Vector3& p_C) {
  Real square = 0;
  Real product = 0;
  for (int k = 0; k < 3; ++k) {
    const Real along = static_cast<Real>(p_B[k]) - p_A[k];
    square += along * along;
    product += along * (static_cast<Real>(p_C[k]) - p_A[k]);
  }
  Truth truth{square > 0 ? std::clamp(product / square, Real{0}, Real{1}) : Real{0}, {}, 0};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const Real along = static_cast<Real>(p_B[i]) - p_A[i];
    truth.offset[k] = static_cast<Real>(p_C[i]) - p_A[i] - truth.lambda * along;
    truth.distance += truth.offset[k] * truth.offset[k];
  }
  truth.distance = std::sqrt(truth.distance);
  return truth;
}

/// 10^x with x uniform in [low, high].
double decade(SplitMix64& random, double low, double high) {
  return std::pow(10.0, random.uniform(low, high));
}

/// Largest error of offset and distance, m.
double error_of(const SegmentPoint& found, const Truth& truth) {
  Real error = std::abs(found.distance - truth.distance);
  for (std::size_t k = 0; k < 3; ++k) {
    const Real part = found.offset[static_cast<Eigen::Index>(k)] - truth.offset[k];
    error = std::max(error, std::abs(part));
  }
  return static_cast<double>(error);
}

}  // namespace

TEST_CASE("the nearest point of a segment is the long double one for lengths from 1 um to 10 Mm") {
  SplitMix64 random(1);
  for (std::int64_t i = 0; i < scaled(1'000'000); ++i) {
    const double L = decade(random, -6.0, 7.0);
    const double d = L * decade(random, -9.0, 3.0);
    const Directions n = random_directions(random);
    const Vector3 p_A = random_vector(random, L);
    const Vector3 p_B = p_A + L * n.along;
    const Vector3 p_C = p_A + random.uniform(-0.5, 1.5) * L * n.along + d * n.across;
    const SegmentPoint found = closest_point_on_segment(p_A, p_B, p_C);
    const Truth truth = truth_of(p_A, p_B, p_C);
    CAPTURE(i);
    REQUIRE(error_of(found, truth) <= 4.0 * kEpsilon * ((p_C - p_A).norm() + L));
    const auto lambda = static_cast<double>(truth.lambda);
    REQUIRE(std::abs(found.lambda - lambda) <= 8.0 * kEpsilon * ((p_C - p_A).norm() / L + 1.0));
    REQUIRE((found.p - (p_A + lambda * (p_B - p_A))).norm() <=
            16.0 * kEpsilon * ((p_C - p_A).norm() + L + p_A.norm()));
    REQUIRE((found.lambda >= 0.0 && found.lambda <= 1.0));
  }
}

TEST_CASE("a string of any length over radius from 1e3 to 1e7 keeps its surface to 1e-8 radii") {
  SplitMix64 random(2);
  for (const double ratio : {1e3, 1e4, 1e5, 1e6, 1e7}) {
    CAPTURE(ratio);
    for (std::int64_t i = 0; i < scaled(100'000); ++i) {
      const double R = decade(random, -9.0, 0.0);
      const double L = R * ratio;
      const Directions n = random_directions(random);
      const Vector3 p_B = L * n.along;
      const Vector3 p_C = random.uniform() * L * n.along + R * random.uniform(0.5, 2.0) * n.across;
      const SegmentPoint found = closest_point_on_segment(Vector3::Zero(), p_B, p_C);
      const Truth truth = truth_of(Vector3::Zero(), p_B, p_C);
      REQUIRE(error_of(found, truth) <= 1e-8 * R);
    }
  }
}

TEST_CASE("at, just outside and just inside an end, lambda is exactly 0, 0 and the way inside") {
  constexpr double kTiny = std::numeric_limits<double>::denorm_min();
  for (const double L : {1e-6, 0.5, 1.1, 1e7}) {
    for (const double d : {0.0, 1e-9, 5e-3, 1e3}) {
      CAPTURE(L);
      CAPTURE(d);
      const auto lambda_at = [&](double x) {
        return closest_point_on_segment({0, 0, 0}, {L, 0, 0}, {x, d, 0}).lambda;
      };
      CHECK(lambda_at(0.0) == 0.0);
      CHECK(lambda_at(-kTiny) == 0.0);
      CHECK(lambda_at(-1e-9 * L) == 0.0);
      CHECK(lambda_at(-1e6 * L) == 0.0);
      CHECK(lambda_at(1e-12 * L) == within(1e-12, 1e-15));
      CHECK(lambda_at(0.25 * L) == within(0.25, 1e-15));
      CHECK(lambda_at(L) == 1.0);
      CHECK(lambda_at(std::nextafter(L, 2 * L)) == 1.0);
      CHECK(lambda_at(1e6 * L) == 1.0);
      const double inside = lambda_at(L * (1.0 - 1e-12));
      CHECK(inside < 1.0);
      CHECK(1.0 - inside == within(1e-12, 1e-3));
      CHECK(lambda_at(std::nextafter(L, 0.0)) <= 1.0);
    }
  }
}

TEST_CASE("beyond an end the nearest point is the end, so that strings have round caps") {
  SplitMix64 random(3);
  for (std::int64_t i = 0; i < scaled(100'000); ++i) {
    const Directions n = random_directions(random);
    const Vector3 p_A = random_vector(random, 1.0);
    const Vector3 p_B = p_A + n.along;
    const Vector3 beyond = random.uniform(1e-3, 2.0) * n.along + random.uniform() * n.across;
    const SegmentPoint at_B = closest_point_on_segment(p_A, p_B, p_B + beyond);
    REQUIRE(at_B.lambda == 1.0);
    REQUIRE(std::abs(at_B.distance - beyond.norm()) <= 1e-15 * 8.0);
    const SegmentPoint at_A = closest_point_on_segment(p_A, p_B, p_A - beyond);
    REQUIRE(at_A.lambda == 0.0);
    REQUIRE(std::abs(at_A.distance - beyond.norm()) <= 1e-15 * 8.0);
  }
}

TEST_CASE("the direction of the distance is continuous over the seam of cylinder and cap") {
  // The distance to a convex set has a gradient that turns by at most step / distance.
  SplitMix64 random(4);
  for (std::int64_t i = 0; i < scaled(300'000); ++i) {
    const double L = decade(random, -3.0, 1.0);
    const double d = decade(random, -4.0, -1.0);
    const double step = d * decade(random, -6.0, -1.0);
    const Directions n = random_directions(random);
    const Vector3 p_A = random_vector(random, L);
    const Vector3 p_B = p_A + L * n.along;
    const Vector3& end = random.chance(0.5) ? p_A : p_B;
    const Vector3 p_C = end + d * n.across + random_vector(random, 0.5 * step);
    const Vector3 p_D = p_C + random_vector(random, 0.5 * step);
    const SegmentPoint a = closest_point_on_segment(p_A, p_B, p_C);
    const SegmentPoint b = closest_point_on_segment(p_A, p_B, p_D);
    const Vector3 turn = a.offset / a.distance - b.offset / b.distance;
    const double moved_by = (p_D - p_C).norm();
    const double rounding = 32.0 * kEpsilon * (L + d);
    REQUIRE(turn.norm() * std::min(a.distance, b.distance) <= moved_by + rounding);
    // And the distance itself follows that gradient: first-order error is second order in the step.
    const double predicted = a.distance + (p_D - p_C).dot(a.offset / a.distance);
    REQUIRE(std::abs(b.distance - predicted) <= moved_by * moved_by / d + rounding);
  }
}

TEST_CASE("a segment without length is a point, whatever the centre") {
  SplitMix64 random(5);
  for (int i = 0; i < 1000; ++i) {
    const Vector3 p_A = random_vector(random, 10.0);
    const Vector3 p_C = i == 0 ? p_A : random_vector(random, 10.0);
    const SegmentPoint found = closest_point_on_segment(p_A, p_A, p_C);
    REQUIRE(found.lambda == 0.0);
    REQUIRE(found.p == p_A);
    REQUIRE(found.offset == p_C - p_A);
    REQUIRE(found.distance == length(p_C - p_A));
  }
}

TEST_CASE("segments around the smallest length turn into points without a bad number") {
  for (const double L :
       {std::numeric_limits<double>::denorm_min(), 1e-320, 1e-200, 1e-151, 0.999 * kMinLength,
        kMinLength, 1.001 * kMinLength, 1e-149, 1e-140, 1e-100}) {
    for (const double x : {-2.0, 0.0, 0.25, 1.0, 3.0}) {
      for (const double d : {0.0, 1.0}) {
        CAPTURE(L);
        CAPTURE(x);
        CAPTURE(d);
        // d is 0 or far longer than the segment: either way the distance is known.
        const SegmentPoint found = closest_point_on_segment({0, 0, 0}, {0, L, 0}, {d, x * L, 0});
        CHECK((found.lambda >= 0.0 && found.lambda <= 1.0));
        CHECK(found.p.allFinite());
        CHECK(found.offset.allFinite());
        if (d > 0.0) {
          CHECK(found.distance == 1.0);
        } else {
          CHECK(found.distance <= std::abs(x) * L);
        }
        if (L > 1.0005 * kMinLength) {
          CHECK(found.lambda == within(std::clamp(x, 0.0, 1.0), 1e-12));
        }
        if (L < kMinLength) CHECK(found.lambda == 0.0);
      }
    }
  }
}

TEST_CASE("coordinates up to the largest allowed stay finite and exact to rounding") {
  SplitMix64 random(6);
  for (const double size : {1e3, 1e9, 1e30, 1e100, 1e149, 1e150}) {
    CAPTURE(size);
    for (int i = 0; i < 2000; ++i) {
      const Vector3 p_A = random_vector(random, size);
      const Vector3 p_B = i % 3 == 0 ? Vector3(p_A + random_vector(random, 1e-3 * size))
                                     : random_vector(random, size);
      const Vector3 p_C = random_vector(random, size);
      const SegmentPoint found = closest_point_on_segment(p_A, p_B, p_C);
      REQUIRE(std::isfinite(found.distance));
      REQUIRE(found.p.allFinite());
      REQUIRE(error_of(found, truth_of(p_A, p_B, p_C)) <= 32.0 * kEpsilon * size);
    }
  }
}

TEST_CASE("naming the segment from the other end changes only lambda") {
  SplitMix64 random(7);
  for (std::int64_t i = 0; i < scaled(100'000); ++i) {
    const Vector3 p_A = random_vector(random, 1.0);
    const Vector3 p_B = random_vector(random, 1.0);
    const Vector3 p_C = random_vector(random, 2.0);
    const SegmentPoint a = closest_point_on_segment(p_A, p_B, p_C);
    const SegmentPoint b = closest_point_on_segment(p_B, p_A, p_C);
    REQUIRE(std::abs(a.distance - b.distance) <= 1e-14);
    REQUIRE((a.offset - b.offset).norm() <= 1e-14);
    REQUIRE(std::abs(a.lambda + b.lambda - 1.0) * (p_B - p_A).norm() <= 1e-14);
  }
}

}  // namespace hapticd::test
