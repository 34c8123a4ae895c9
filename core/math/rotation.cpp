// Rotation vectors and unit quaternions. The angle comes from arctangent2(|v|, w), which is
// accurate for every rotation, where the arc cosine of w loses half the digits near 0 and the arc
// sine of |v| near pi (cf. Sola, "Quaternion kinematics for the error-state Kalman filter",
// 2017). Sums are written out so that no library decides their order. RT: yes.
#include "core/math/rotation.h"

#include <cmath>

#include "core/math/elementary.h"

namespace hapticd {
namespace {

/// Square of the angle, rad^2, or of half of it, below which the first term of the series is exact
/// to the last bit: the next is at most a third of this, relative. Larger: wrong last bits; 0: 0/0
/// at the identity.
constexpr double kSmallSquared = 0x1p-54;

double squared_length(const Vector3& v) noexcept {
  return (v.x() * v.x() + v.y() * v.y()) + v.z() * v.z();
}

/// Rotation vector of length [0, 2 pi) along `v`: angle/2 is that of the point (w, |v|), both signs
/// of w.
Vector3 rotation_vector(double w, const Vector3& v) noexcept {
  const double length = std::sqrt(squared_length(v));
  return v * (2.0 * arctangent2(length, w) / length);
}

}  // namespace

Quaternion exp_rotation(const Vector3& phi) noexcept {
  const double angle_squared = squared_length(phi);
  if (angle_squared < kSmallSquared) return {1.0, 0.5 * phi.x(), 0.5 * phi.y(), 0.5 * phi.z()};
  const double angle = std::sqrt(angle_squared);
  const SinCos half = sin_cos(0.5 * angle);
  const double scale = half.sin / angle;
  return {half.cos, scale * phi.x(), scale * phi.y(), scale * phi.z()};
}

Vector3 log_rotation(const Quaternion& q) noexcept {
  if (squared_length(q.vec()) < kSmallSquared) return q.vec() * (2.0 / q.w());
  // q and -q are one rotation; the one with w >= 0 is at most pi from the identity.
  return q.w() < 0.0 ? rotation_vector(-q.w(), -q.vec()) : rotation_vector(q.w(), q.vec());
}

Vector3 log_rotation_near(const Quaternion& q, const Vector3& phi_reference,
                          double max_angle) noexcept {
  Vector3 principal = log_rotation(q);
  // Next to the identity the other branch is a full turn about an axis that rounding decides.
  if (squared_length(q.vec()) < kSmallSquared) return principal;
  Vector3 other = q.w() < 0.0 ? rotation_vector(q.w(), q.vec()) : rotation_vector(-q.w(), -q.vec());
  if (squared_length(other) > max_angle * max_angle) return principal;
  const bool other_is_nearer =
      squared_length(other - phi_reference) < squared_length(principal - phi_reference);
  return other_is_nearer ? other : principal;
}

}  // namespace hapticd
