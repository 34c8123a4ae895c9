// Rigid poses in monogram notation: X_AB maps coordinates in frame B to frame A, p_A = R_AB p_B +
// p_AB. Quaternions are unit to 1e-12 (renormalised after each composition step that is committed).
// SI. RT: yes.
#pragma once

#include <cmath>

#include "core/math/vector.h"

namespace hapticd {

/// Pose X_AB of frame B in frame A: `q` = orientation R_AB, `p` = origin of B in A, m.
struct Pose {
  Quaternion q{1.0, 0.0, 0.0, 0.0};
  Vector3 p{0.0, 0.0, 0.0};
};

/// p_AQ from p_BQ: the point given in B, expressed in A. 30 flops.
[[nodiscard]] inline Vector3 transform(const Pose& X_AB, const Vector3& p_BQ) noexcept {
  return X_AB.q * p_BQ + X_AB.p;
}

/// X_BA from X_AB.
[[nodiscard]] inline Pose inverse(const Pose& X_AB) noexcept {
  const Quaternion q_BA = X_AB.q.conjugate();
  return {q_BA, -(q_BA * X_AB.p)};
}

/// The same rotation with |q| = 1. Precondition: |q| finite and not 0.
[[nodiscard]] inline Quaternion renormalised(const Quaternion& q) noexcept {
  const double norm = std::sqrt((q.w() * q.w() + q.x() * q.x()) + (q.y() * q.y() + q.z() * q.z()));
  return {q.w() / norm, q.x() / norm, q.y() / norm, q.z() / norm};
}

}  // namespace hapticd
