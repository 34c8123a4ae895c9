// Twists and wrenches as 6-vectors [linear; angular]. A twist V_AB_C: velocity of B relative to A,
// expressed in C. A wrench F_P_C: force and torque about the point P, expressed in C. SI: m/s,
// rad/s, N, N m. RT: yes.
#pragma once

#include "core/math/vector.h"

namespace hapticd {

/// [v; w], m/s and rad/s.
struct Twist {
  Vector3 v{0.0, 0.0, 0.0};
  Vector3 w{0.0, 0.0, 0.0};
};

/// [f; t], N and N m about a stated point.
struct Wrench {
  Vector3 f{0.0, 0.0, 0.0};
  Vector3 t{0.0, 0.0, 0.0};
};

/// F_Q from F_P: the same load with its torque taken about Q; p_QP = P - Q, same frame.
[[nodiscard]] inline Wrench shift(const Wrench& F_P, const Vector3& p_QP) noexcept {
  return {F_P.f, F_P.t + p_QP.cross(F_P.f)};
}

/// Velocity of the point Q fixed to the moving frame, from the twist of its origin P; p_PQ = Q - P.
[[nodiscard]] inline Vector3 point_velocity(const Twist& V_P, const Vector3& p_PQ) noexcept {
  return V_P.v + V_P.w.cross(p_PQ);
}

/// Mechanical power of a wrench on a twist about the same point, W.
[[nodiscard]] inline double power(const Wrench& F, const Twist& V) noexcept {
  return F.f.dot(V.v) + F.t.dot(V.w);
}

}  // namespace hapticd
