// Sine, cosine, arctangent, exponential and logarithm from our own polynomials: libm's differ
// between CPU variants and versions, and the haptic path promises equal bits for equal input
// everywhere. Only + - * / of doubles, no contraction; fit_elementary.py derives the constants.
// RT: yes, about 100 cycles each.
#pragma once

#include "core/math/realtime.h"

namespace hapticd {

/// Sine and cosine of one angle.
struct SinCos {
  double sin;
  double cos;
};

inline constexpr double kPi = 3.14159265358979323846;

/// sin and cos of `angle`, rad, |angle| <= 1e5; relative error of each <= 2e-16, near their zeros
/// too. Odd and even to the bit. Beyond 1e5, or for a non-finite angle: {NaN, NaN}.
[[nodiscard]] HD_REALTIME SinCos sin_cos(double angle) noexcept;

/// Angle of the point (x, y) from the x axis, in [-pi, pi], rad; relative error <= 3e-16 (absolute
/// 5e-324 where y/x underflows). Odd in y to the bit; y = +-0 left of the origin gives +-pi; at the
/// origin y itself, whatever the signs; NaN if an argument is not finite.
[[nodiscard]] HD_REALTIME double arctangent2(double y, double x) noexcept;

/// e^x; error below one unit in the last place, subnormal results included. 1 at +-0; 0 below
/// -745.13, infinity above 709.78; NaN for NaN.
[[nodiscard]] HD_REALTIME double exponential(double x) noexcept;

/// Natural logarithm; error below one unit in the last place, subnormal arguments included. +0 at
/// 1, -infinity at +-0, infinity at infinity; NaN below 0 and for NaN.
[[nodiscard]] HD_REALTIME double logarithm(double x) noexcept;

}  // namespace hapticd
