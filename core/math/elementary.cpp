// Sine, cosine, arctangent, exponential and logarithm by argument reduction and minimax
// polynomials. Reduction after Cody and Waite, "Software Manual for the Elementary Functions"
// (1980): pi/2 and log 2 in parts short enough that n times a part is exact. All constants come
// from fit_elementary.py. The order of every sum is part of the result: a different order gives
// other last bits. RT: yes.
#include "core/math/elementary.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace hapticd {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Largest reducible angle, rad. Its 63 662 quarter turns fit the 17 bits that keep n times a part
/// of pi/2 exact; beyond 2^17 quarter turns the reduction would lose bits.
constexpr double kMaxAngle = 1e5;

constexpr double kTwoOverPi = 0x1.45f306dc9c883p-1;
constexpr double kHalfPi1 = 0x1.921fb54440000p+0;
constexpr double kHalfPi2 = 0x1.68c234c4c0000p-39;
constexpr double kHalfPi3 = 0x1.98a2e03707345p-77;

/// k pi/4 = high + low.
struct Sum {
  double high;
  double low;
};
constexpr Sum kEighthTurns[] = {{0.0, 0.0},
                                {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55},
                                {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54},
                                {0x1.2d97c7f3321d2p+1, 0x1.a79394c9e8a0ap-54},
                                {0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53}};

/// Above this ratio the arctangent is taken relative to pi/4.
constexpr double kTanEighthPi = 0x1.a827999fcef32p-2;

constexpr double kLog2High = 0x1.62e42fefa3800p-1;
constexpr double kLog2Low = 0x1.ef35793c76730p-45;
constexpr double kOneOverLog2 = 0x1.71547652b82fep+0;
constexpr double kSqrt2 = 0x1.6a09e667f3bcdp+0;

/// Above the first the exponential is not a finite double, below the second it rounds to 0.
constexpr double kMaxExponent = 0x1.62e42fefa39efp+9;
constexpr double kMinExponent = -0x1.74910d52d3052p+9;

constexpr int kMantissaBits = 52;
constexpr int kExponentBias = 1023;

/// angle = quarter_turns pi/2 + remainder + tail, |remainder| <= pi/4 (to rounding), tail below its
/// last bit.
struct Reduced {
  double remainder;
  double tail;
  unsigned quarter_turns;
};

Reduced reduce(double angle) noexcept {
  const double turns = angle * kTwoOverPi;
  const int n = static_cast<int>(turns + (turns < 0.0 ? -0.5 : 0.5));
  const double count = n;

  // The first difference is exact: both are multiples of the last bit and nearly equal. The second
  // keeps its rounding error.
  const double a = angle - count * kHalfPi1;
  const double b = count * kHalfPi2;
  const double high = a - b;
  const double b_seen = a - high;
  const double error = (a - (high + b_seen)) + (b_seen - b);
  const double low = error - count * kHalfPi3;

  const double remainder = high + low;
  return {remainder, (high - remainder) + low, static_cast<unsigned>(n) & 3U};
}

/// sin(r + tail), |r| <= pi/4.
double sin_reduced(double r, double tail) noexcept {
  const double z = r * r;
  const double z2 = z * z;
  const double even =
      -0x1.5555555555555p-3 + z2 * (-0x1.a01a019e83e31p-13 + z2 * -0x1.ae600b3db9701p-26);
  const double odd =
      0x1.1111111110bb3p-7 + z2 * (0x1.71de3796c9c52p-19 + z2 * 0x1.5e0b2d1aac9ddp-33);
  return r + (r * z * (even + z * odd) + tail * (1.0 - 0.5 * z));
}

/// cos(r + tail), |r| <= pi/4.
double cos_reduced(double r, double tail) noexcept {
  const double z = r * r;
  const double z2 = z * z;
  const double even =
      0x1.5555555555555p-5 + z2 * (0x1.a01a019f4ec90p-16 + z2 * 0x1.1eeb69037a8fdp-29);
  const double odd =
      -0x1.6c16c16c16967p-10 + z2 * (-0x1.27e4fa17f65f8p-22 + z2 * -0x1.907db46c8b3eep-37);
  // 1 - z/2 with its rounding error, so that the large terms lose nothing.
  const double half = 0.5 * z;
  const double large = 1.0 - half;
  return large + (((1.0 - large) - half) + (z2 * (even + z * odd) - r * tail));
}

/// atan(t) - t, |t| <= tan(pi/8).
double arctangent_excess(double t) noexcept {
  const double z = t * t;
  const double z2 = z * z;
  const double even =
      -0x1.5555555555555p-2 +
      z2 * (-0x1.249249243a71fp-3 +
            z2 * (-0x1.745d0b879af73p-4 +
                  z2 * (-0x1.10fae23f3c759p-4 +
                        z2 * (-0x1.a0bb56224a6b6p-5 + z2 * -0x1.3b08ed9a0fb32p-6))));
  const double odd =
      0x1.99999999993a8p-3 +
      z2 * (0x1.c71c7187c070cp-4 +
            z2 * (0x1.3b126b14b3937p-4 + z2 * (0x1.dfed1a430047ap-5 + z2 * 0x1.41bf28289ad17p-5)));
  return t * z * (even + z * odd);
}

/// 2^n, -1022 <= n <= 1023.
double power_of_two(int n) noexcept {
  return std::bit_cast<double>(static_cast<std::uint64_t>(n + kExponentBias) << kMantissaBits);
}

/// (r coth(r/2) - 2) / z, z = r^2, |r| <= log(2) / 2.
double coth_excess(double z) noexcept {
  const double z2 = z * z;
  const double even =
      0x1.5555555555553p-3 + z2 * (0x1.1566ab5c2ba14p-14 + z2 * 0x1.63f2a09c9432bp-25);
  const double odd = -0x1.6c16c16c0ac3dp-9 + z2 * -0x1.bbd53273e99b2p-20;
  return even + z * odd;
}

/// (log((1 + s) / (1 - s)) / s - 2) / z, z = s^2, |s| <= (sqrt 2 - 1) / (sqrt 2 + 1).
double logarithm_excess(double z) noexcept {
  const double z2 = z * z;
  const double even =
      0x1.5555555555558p-1 +
      z2 * (0x1.2492492e02a9cp-2 + z2 * (0x1.7462b9b6f6c64p-3 + z2 * 0x1.2b5f0a346457dp-3));
  const double odd = 0x1.999999999522fp-2 + z2 * (0x1.c71c62d1ccb69p-3 + z2 * 0x1.39fdc7ebbd547p-3);
  return even + z * odd;
}

}  // namespace

SinCos sin_cos(double angle) noexcept {
  if (!(std::abs(angle) <= kMaxAngle)) return {kNan, kNan};
  const Reduced reduced = reduce(angle);
  const double s = sin_reduced(reduced.remainder, reduced.tail);
  const double c = cos_reduced(reduced.remainder, reduced.tail);
  switch (reduced.quarter_turns) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

double arctangent2(double y, double x) noexcept {
  if (!std::isfinite(y) || !std::isfinite(x)) return kNan;
  double y_size = std::abs(y);
  double x_size = std::abs(x);
  if (y_size > 0x1p1000 || x_size > 0x1p1000) {
    // The sum below must not overflow; what underflows here is 2^-900 of the other.
    y_size *= 0x1p-100;
    x_size *= 0x1p-100;
  }
  const bool steep = y_size > x_size;
  const double small = steep ? x_size : y_size;
  const double large = steep ? y_size : x_size;
  if (large == 0.0) return y;

  // The angle in the first octant is [pi/4 +] atan(t).
  const bool near_diagonal = small > kTanEighthPi * large;
  double t = near_diagonal ? (small - large) / (small + large) : small / large;
  std::size_t eighth_turns = near_diagonal ? 1 : 0;

  // Reflect at the diagonal, then at the y axis.
  if (steep) {
    t = -t;
    eighth_turns = 2 - eighth_turns;
  }
  if (x < 0.0) {
    t = -t;
    eighth_turns = 4 - eighth_turns;
  }
  const Sum base = kEighthTurns[eighth_turns];
  return std::copysign(base.high + (t + (arctangent_excess(t) + base.low)), y);
}

double exponential(double x) noexcept {
  if (!(x <= kMaxExponent)) return x > kMaxExponent ? kInfinity : kNan;
  if (x < kMinExponent) return 0.0;

  // x = n log 2 + (high - low); the first product and difference are exact.
  const double powers = x * kOneOverLog2;
  const int n = static_cast<int>(powers + (powers < 0.0 ? -0.5 : 0.5));
  const double high = x - n * kLog2High;
  const double low = n * kLog2Low;
  const double r = high - low;

  // exp(r) = 1 + 2 r / (r coth(r/2) - r) = 1 + r + r c / (2 - c): the rounding errors of the
  // fraction are small beside 1.
  const double z = r * r;
  const double c = r - z * coth_excess(z);
  const double result = 1.0 + (high + (r * c / (2.0 - c) - low));

  // In two factors, as 2^n itself may be no normal number: only the last product rounds.
  const int half = n / 2;
  return result * power_of_two(half) * power_of_two(n - half);
}

double logarithm(double x) noexcept {
  if (!(x > 0.0)) return x == 0.0 ? -kInfinity : kNan;
  if (x == kInfinity) return x;
  int n = 0;
  if (x < std::numeric_limits<double>::min()) {
    x *= 0x1p54;
    n = -54;
  }

  // x = 2^n m, m in (sqrt(1/2), sqrt 2].
  const auto bits = std::bit_cast<std::uint64_t>(x);
  n += static_cast<int>(bits >> kMantissaBits) - kExponentBias;
  double m = std::bit_cast<double>((bits & ((std::uint64_t{1} << kMantissaBits) - 1)) |
                                   (std::uint64_t{kExponentBias} << kMantissaBits));
  if (m > kSqrt2) {
    m *= 0.5;
    ++n;
  }

  // log(1 + f) = s (2 + z excess) with s = f / (2 + f), and 2 s = f - s f: f itself is exact, and
  // what is added to it is small beside it. f - s f = f - f^2/2 + s f^2/2 keeps one digit more.
  const double f = m - 1.0;
  const double s = f / (2.0 + f);
  const double z = s * s;
  const double half_square = 0.5 * f * f;
  const double small = s * (half_square + z * logarithm_excess(z)) + n * kLog2Low;
  return n * kLog2High - ((half_square - small) - f);
}

}  // namespace hapticd
