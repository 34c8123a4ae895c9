// Rotations the slow way, as the truth for core/math: 3x3 matrices of long double (64-bit
// mantissa), the rotation vector by Rodrigues' formula with libm's functions. Shares no code with
// what it judges. Tests only.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "core/math/pose.h"
#include "core/math/vector.h"
#include "tests/support/random.h"

namespace hapticd::test {

using Real = long double;
using LongVector3 = std::array<Real, 3>;
using LongMatrix3 = std::array<LongVector3, 3>;

inline LongVector3 to_long(const Vector3& v) { return {Real(v.x()), Real(v.y()), Real(v.z())}; }

inline Vector3 to_vector3(const LongVector3& v) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

inline LongVector3 product(const LongMatrix3& m, const LongVector3& v) {
  LongVector3 result{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) result[i] += m[i][j] * v[j];
  }
  return result;
}

inline LongMatrix3 product(const LongMatrix3& a, const LongMatrix3& b) {
  LongMatrix3 result{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) result[i][j] += a[i][k] * b[k][j];
    }
  }
  return result;
}

inline LongMatrix3 transposed(const LongMatrix3& m) {
  LongMatrix3 result{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) result[i][j] = m[j][i];
  }
  return result;
}

/// Rotation by `angle`, rad, about the unit vector `axis`: I + sin K + (1 - cos) K^2.
inline LongMatrix3 rodrigues(const LongVector3& axis, Real angle) {
  const LongMatrix3 k{{{0, -axis[2], axis[1]}, {axis[2], 0, -axis[0]}, {-axis[1], axis[0], 0}}};
  const LongMatrix3 k2 = product(k, k);
  // 1 - cos without cancellation.
  const Real versine = 2 * sinl(angle / 2) * sinl(angle / 2);
  LongMatrix3 result{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) result[i][j] += sinl(angle) * k[i][j] + versine * k2[i][j];
  }
  return result;
}

/// Matrix of a unit quaternion, by its definition R e_j = q e_j q*.
inline LongMatrix3 matrix_of(const Quaternion& q) {
  const Real w = Real(q.w()), x = Real(q.x()), y = Real(q.y()), z = Real(q.z());
  return {{{w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)},
           {2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)},
           {2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z}}};
}

/// Largest difference of two entries.
inline Real distance(const LongMatrix3& a, const LongMatrix3& b) {
  Real worst = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) worst = fmaxl(worst, fabsl(a[i][j] - b[i][j]));
  }
  return worst;
}

/// Largest difference of two components.
inline Real distance(const LongVector3& a, const LongVector3& b) {
  return fmaxl(fabsl(a[0] - b[0]), fmaxl(fabsl(a[1] - b[1]), fabsl(a[2] - b[2])));
}

inline Real length(const LongVector3& v) { return sqrtl(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

inline Real length(const Quaternion& q) {
  const Real w = Real(q.w()), x = Real(q.x()), y = Real(q.y()), z = Real(q.z());
  return sqrtl(w * w + x * x + y * y + z * z);
}

/// Uniform direction, unit in long double.
inline LongVector3 random_axis(SplitMix64& random) {
  const std::array<double, 3> d = random.direction();
  const LongVector3 v{Real(d[0]), Real(d[1]), Real(d[2])};
  const Real n = length(v);
  return {v[0] / n, v[1] / n, v[2] / n};
}

/// The unit quaternion of the rotation by `angle` about the unit vector `axis`, each component
/// rounded once.
inline Quaternion reference_quaternion(const LongVector3& axis, Real angle) {
  const Real s = sinl(angle / 2);
  return {static_cast<double>(cosl(angle / 2)), static_cast<double>(s * axis[0]),
          static_cast<double>(s * axis[1]), static_cast<double>(s * axis[2])};
}

/// Any orientation, and a place within `reach`, m.
inline Pose random_pose(SplitMix64& random, double reach) {
  const LongVector3 axis = random_axis(random);
  return {reference_quaternion(axis, Real(random.uniform(-3.2, 3.2))),
          {random.uniform(-reach, reach), random.uniform(-reach, reach),
           random.uniform(-reach, reach)}};
}

}  // namespace hapticd::test
