// Rotation vectors (exponential coordinates): phi = angle * axis, radians, |phi| <= pi for the
// principal branch. Exact at 0 and at pi: no division by a vanishing sine anywhere. Only own
// polynomials and sqrt, so results are bit-identical across compilers and CPUs. RT: yes, about 150
// cycles each.
#pragma once

#include "core/math/realtime.h"
#include "core/math/vector.h"

namespace hapticd {

/// Unit quaternion of the rotation vector `phi` (any finite length below 1e5 rad).
[[nodiscard]] HD_REALTIME Quaternion exp_rotation(const Vector3& phi) noexcept;

/// Principal rotation vector of quaternion `q`, unit to a part in a million; q and -q give the same
/// bits except at exactly pi (w = 0), where the axis is the vector part as given. |result| <= pi
/// (to rounding).
[[nodiscard]] HD_REALTIME Vector3 log_rotation(const Quaternion& q) noexcept;

/// The rotation vector of `q` on the branch nearest to `phi_reference`: the principal one, or the
/// one 2 pi beyond it, so that a torque computed from it does not flip sign while the rotation
/// passes pi. |result| <= `max_angle` (pi <= max_angle < 2 pi); past that the principal branch is
/// returned.
[[nodiscard]] HD_REALTIME Vector3 log_rotation_near(const Quaternion& q,
                                                    const Vector3& phi_reference,
                                                    double max_angle) noexcept;

}  // namespace hapticd
