// Sine, cosine, arctangent, exponential and logarithm against libm's long double functions (error
// below 1e-19).
#include "core/math/elementary.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace {

using hapticd::arctangent2;
using hapticd::exponential;
using hapticd::kPi;
using hapticd::logarithm;
using hapticd::sin_cos;
using hapticd::SinCos;
using hapticd::test::scaled;
using hapticd::test::SplitMix64;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kTiny = std::numeric_limits<double>::denorm_min();
constexpr double kHuge = std::numeric_limits<double>::max();

using Real = long double;

/// Relative error the headers promise; a unit in the last place is 1.1e-16 to 2.2e-16.
constexpr Real kSinCosError = 2e-16L;
constexpr Real kArctangentError = 3e-16L;

Real relative_error(double value, Real truth) {
  const Real error = fabsl(Real(value) - truth);
  return truth == 0 ? error : error / fabsl(truth);
}

Real sin_cos_error(double angle) {
  const SinCos result = sin_cos(angle);
  return fmaxl(relative_error(result.sin, sinl(Real(angle))),
               relative_error(result.cos, cosl(Real(angle))));
}

Real arctangent_error(double y, double x) {
  return relative_error(arctangent2(y, x), atan2l(Real(y), Real(x)));
}

/// The same of the exponential and the logarithm, in units in the last place of the truth.
constexpr Real kExponentialUlp = 1.0L;
constexpr Real kLogarithmUlp = 1.0L;

/// Error of value in units in the last place of a double near truth; a subnormal's unit is kTiny.
Real ulp_error(double value, Real truth) {
  if (Real(value) == truth) return 0;
  const int exponent = std::max(ilogbl(truth), -1022);
  return fabsl(Real(value) - truth) / ldexpl(1.0L, exponent - 52);
}

Real exponential_error(double x) { return ulp_error(exponential(x), expl(Real(x))); }

Real logarithm_error(double x) { return ulp_error(logarithm(x), logl(Real(x))); }

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

/// A number of random sign whose logarithm is uniform.
double log_uniform(SplitMix64& random, double low_exponent, double high_exponent) {
  const double size = std::exp2(random.uniform(low_exponent, high_exponent));
  return random.chance(0.5) ? size : -size;
}

}  // namespace

TEST_CASE("sine and cosine are within 2e-16 of the truth, relative, for random angles") {
  SplitMix64 random(101);
  Real worst = 0;
  const std::int64_t count = scaled(3'000'000);
  for (std::int64_t i = 0; i < count; ++i) {
    worst = fmaxl(worst, sin_cos_error(random.uniform(-2 * kPi, 2 * kPi)));
    worst = fmaxl(worst, sin_cos_error(random.uniform(-1e5, 1e5)));
    worst = fmaxl(worst, sin_cos_error(log_uniform(random, -1000.0, 16.0)));
  }
  CHECK(worst <= kSinCosError);
}

TEST_CASE("sine and cosine keep their relative accuracy next to their zeros and octant edges") {
  SplitMix64 random(102);
  Real worst = 0;
  const std::int64_t eighth_turns = 127'323;  // 1e5 rad
  const std::int64_t step = std::max<std::int64_t>(1, eighth_turns / scaled(eighth_turns));
  for (std::int64_t k =
           1 + static_cast<std::int64_t>(random.below(static_cast<std::uint64_t>(step)));
       k <= eighth_turns; k += step) {
    const double angle =
        static_cast<double>(static_cast<Real>(k) * 0.785398163397448309615660845819876L);
    for (const double neighbour :
         {angle, std::nextafter(angle, 0.0), std::nextafter(angle, kInfinity), -angle}) {
      worst = fmaxl(worst, sin_cos_error(neighbour));
    }
  }
  CHECK(worst <= kSinCosError);
}

TEST_CASE("sine and cosine of zero, tiny angles and the ends of the range are right") {
  CHECK(sin_cos(0.0).sin == 0.0);
  CHECK(sin_cos(0.0).cos == 1.0);
  for (const double angle : {kTiny, 1e-310, 2.3e-308, 1e-300, 1e-160, 1e-20, 1e-8}) {
    CHECK(sin_cos(angle).sin == static_cast<double>(sinl(Real(angle))));
    CHECK(sin_cos(-angle).sin == static_cast<double>(-sinl(Real(angle))));
    CHECK(sin_cos(angle).cos == static_cast<double>(cosl(Real(angle))));
  }
  CHECK(sin_cos_error(1e5) <= kSinCosError);
  CHECK(sin_cos_error(-1e5) <= kSinCosError);
}

TEST_CASE("sine and cosine of an angle beyond 1e5, infinite or not a number are not numbers") {
  for (const double angle : {std::nextafter(1e5, kInfinity), 1e6, 1e300, kHuge, kInfinity, kNan}) {
    for (const double signed_angle : {angle, -angle}) {
      CHECK(std::isnan(sin_cos(signed_angle).sin));
      CHECK(std::isnan(sin_cos(signed_angle).cos));
    }
  }
}

TEST_CASE("sine is odd and cosine even to the bit, and their squares sum to 1") {
  SplitMix64 random(103);
  bool symmetric = true;
  double worst = 0.0;
  const std::int64_t count = scaled(1'000'000);
  for (std::int64_t i = 0; i < count; ++i) {
    const double angle = random.uniform(-1e5, 1e5);
    const SinCos plus = sin_cos(angle);
    const SinCos minus = sin_cos(-angle);
    symmetric = symmetric && same_bits(plus.sin, -minus.sin) && same_bits(plus.cos, minus.cos);
    worst = std::max(worst, std::abs(plus.sin * plus.sin + plus.cos * plus.cos - 1.0));
  }
  CHECK(symmetric);
  CHECK(worst <= 5e-16);
}

TEST_CASE("the arctangent is within 3e-16 of the truth, relative, for random points") {
  SplitMix64 random(104);
  Real worst = 0;
  const std::int64_t count = scaled(3'000'000);
  for (std::int64_t i = 0; i < count; ++i) {
    worst = fmaxl(worst, arctangent_error(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)));
    // Any pair of magnitudes whose ratio is a normal number.
    const double x = log_uniform(random, -500.0, 500.0);
    worst = fmaxl(worst, arctangent_error(x * log_uniform(random, -500.0, 500.0), x));
    worst = fmaxl(
        worst, arctangent_error(log_uniform(random, -2.0, 2.0), random.chance(0.5) ? 1.0 : -1.0));
  }
  CHECK(worst <= kArctangentError);
}

TEST_CASE("the arctangent is accurate on both sides of every edge between its formulas") {
  Real worst = 0;
  for (const double edge : {0.4142135623730950488, 1.0, 2.4142135623730950488}) {
    for (const double above : {edge, std::nextafter(edge, 0.0), std::nextafter(edge, 3.0)}) {
      for (const double scale : {0x1p-1000, 1.0, 0x1p999, 0x1p1022}) {
        worst = fmaxl(worst, arctangent_error(above * scale, scale));
        worst = fmaxl(worst, arctangent_error(-above * scale, -scale));
      }
    }
  }
  CHECK(worst <= kArctangentError);
}

TEST_CASE("the arctangent is accurate where the sum of the coordinates overflows") {
  for (const double ratio : {0.42, 0.5, 0.75, 0.999}) {
    for (const double sign : {1.0, -1.0}) {
      CHECK(arctangent_error(sign * kHuge, ratio * kHuge) <= kArctangentError);
      CHECK(arctangent_error(ratio * kHuge, sign * kHuge) <= kArctangentError);
    }
  }
}

TEST_CASE(
    "the arctangent of points on the axes and diagonals is the multiple of pi/4 nearest the "
    "truth") {
  for (const double r : {kTiny, 1e-310, 1.0, 1e154, kHuge}) {
    CHECK(arctangent2(0.0, r) == 0.0);
    CHECK(arctangent2(r, r) == kPi / 4);
    CHECK(arctangent2(r, 0.0) == kPi / 2);
    CHECK(arctangent2(r, -0.0) == kPi / 2);
    CHECK(arctangent2(r, -r) == 3 * kPi / 4);
    CHECK(arctangent2(0.0, -r) == kPi);
    CHECK(arctangent2(-0.0, -r) == -kPi);
    CHECK(arctangent2(-r, -r) == -3 * kPi / 4);
    CHECK(arctangent2(-r, 0.0) == -kPi / 2);
    CHECK(arctangent2(-r, r) == -kPi / 4);
  }
  CHECK(arctangent2(kHuge, kTiny) == kPi / 2);
  CHECK(arctangent2(kTiny, kHuge) == 0.0);
  CHECK(arctangent2(kTiny, -kHuge) == kPi);
}

TEST_CASE("the arctangent of the origin is 0 and of a point at infinity not a number") {
  for (const double y : {0.0, -0.0}) {
    for (const double x : {0.0, -0.0}) CHECK(same_bits(arctangent2(y, x), y));
  }
  for (const double bad : {kInfinity, -kInfinity, kNan}) {
    for (const double other : {0.0, 1.0, kTiny, kHuge, kInfinity, kNan}) {
      CHECK(std::isnan(arctangent2(bad, other)));
      CHECK(std::isnan(arctangent2(other, bad)));
    }
  }
}

TEST_CASE("the arctangent is odd in y and unchanged by a power of two in both, to the bit") {
  SplitMix64 random(105);
  bool odd = true;
  bool scale_free = true;
  Real worst_reflection = 0;
  const std::int64_t count = scaled(1'000'000);
  for (std::int64_t i = 0; i < count; ++i) {
    const double y = random.uniform(-1.0, 1.0);
    const double x = random.uniform(-1.0, 1.0);
    const double angle = arctangent2(y, x);
    odd = odd && same_bits(angle, -arctangent2(-y, x));
    const double scale = std::ldexp(1.0, static_cast<int>(random.below(1900)) - 900);
    scale_free = scale_free && same_bits(angle, arctangent2(y * scale, x * scale));
    // A quarter turn of the point adds pi/2.
    const Real turned = Real(arctangent2(x, -y)) - Real(angle);
    const Real excess = turned - 1.57079632679489661923132169163975144L;
    worst_reflection =
        fmaxl(worst_reflection, fabsl(remainderl(excess, 6.28318530717958647692528676655900577L)));
  }
  CHECK(odd);
  CHECK(scale_free);
  CHECK(worst_reflection <= 8e-16L);
}

TEST_CASE("the exponential is within one unit in the last place of the truth") {
  SplitMix64 random(106);
  Real worst = 0;
  const std::int64_t count = scaled(3'000'000);
  for (std::int64_t i = 0; i < count; ++i) {
    worst = fmaxl(worst, exponential_error(random.uniform(-745.0, 709.0)));
    worst = fmaxl(worst, exponential_error(random.uniform(-1.0, 1.0)));
    worst = fmaxl(worst, exponential_error(log_uniform(random, -1000.0, 9.0)));
  }
  CHECK(worst <= kExponentialUlp);
}

TEST_CASE("the exponential is accurate on both sides of every edge between powers of two") {
  Real worst = 0;
  for (int n = -1074; n <= 1022; ++n) {
    const double edge = static_cast<double>((Real(n) + 0.5L) * 0.693147180559945309417232121458L);
    for (const double x : {edge, std::nextafter(edge, -kInfinity), std::nextafter(edge, kInfinity),
                           n * 0.69314718055994530942}) {
      worst = fmaxl(worst, exponential_error(x));
    }
  }
  CHECK(worst <= kExponentialUlp);
}

TEST_CASE("the exponential is 1 at 0 and next to it, 0 far below, infinite far above") {
  for (const double x : {0.0, -0.0, kTiny, -kTiny, 1e-310, 1e-17, -1e-17}) {
    CHECK(exponential(x) == 1.0);
  }
  CHECK(exponential(1.0) == hapticd::test::within(2.718281828459045235, 1e-15));
  CHECK(exponential_error(709.782712893383973) <= kExponentialUlp);
  CHECK(exponential(709.78271289338409) == kInfinity);
  CHECK(exponential(kHuge) == kInfinity);
  CHECK(exponential(kInfinity) == kInfinity);
  CHECK(exponential(-744.5) == kTiny);
  CHECK(exponential(-745.13321910194123) <= kTiny);
  for (const double x : {-745.2, -1e4, -1e300, -kHuge, -kInfinity}) {
    CHECK(same_bits(exponential(x), 0.0));
  }
  CHECK(std::isnan(exponential(kNan)));
}

TEST_CASE("the logarithm is within one unit in the last place of the truth") {
  SplitMix64 random(107);
  Real worst = 0;
  const std::int64_t count = scaled(3'000'000);
  for (std::int64_t i = 0; i < count; ++i) {
    worst = fmaxl(worst, logarithm_error(std::abs(log_uniform(random, -1074.0, 1024.0))));
    worst = fmaxl(worst, logarithm_error(random.uniform(0.3, 3.0)));
    worst = fmaxl(worst, logarithm_error(1.0 + log_uniform(random, -52.0, -2.0)));
  }
  CHECK(worst <= kLogarithmUlp);
}

TEST_CASE("the logarithm is accurate on both sides of 1, of sqrt 2 and of powers of two") {
  Real worst = 0;
  for (int n = -1074; n <= 1022; ++n) {
    for (const double m : {1.0, 1.4142135623730950488}) {
      const double x = std::ldexp(m, n);
      for (const double near : {x, std::nextafter(x, 0.0), std::nextafter(x, kInfinity)}) {
        if (near > 0.0) worst = fmaxl(worst, logarithm_error(near));
      }
    }
  }
  CHECK(logarithm_error(kHuge) <= kLogarithmUlp);
  CHECK(worst <= kLogarithmUlp);
}

TEST_CASE("the logarithm of 1 is 0, of 0 minus infinity, of a negative number not a number") {
  CHECK(same_bits(logarithm(1.0), 0.0));
  CHECK(logarithm(0.0) == -kInfinity);
  CHECK(logarithm(-0.0) == -kInfinity);
  CHECK(logarithm(kInfinity) == kInfinity);
  for (const double bad : {-kTiny, -1.0, -kHuge, -kInfinity, kNan}) {
    CHECK(std::isnan(logarithm(bad)));
  }
}
