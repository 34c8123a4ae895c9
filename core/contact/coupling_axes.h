// The law of a coupling whose axes differ in stiffness: the gradient of one potential of both
// poses,
//   U = 1/2 dp' K_W dp + 1/2 phi_G' Kr phi_G,   dp = p_WH - p_WG,   exp(phi_G) = R_GW R_WH,
// K_W = diag along the axes of W, Kr = diag about the tool's own. The rotation vector is the same
// in G and in H, so both read the same axes, and U does not change when both turn together: the
// torques on hand and tool are equal and opposite. With phi = R_WG phi_G and J the inverse of the
// right Jacobian of SO(3) at phi,
//   force on G = K_W dp,   torque on G = J' Kr_W phi,   Kr_W = R_WH Kr R_WH',
// and the hand gets minus both about its own origin: a translation alone turns neither. Springs
// along axes that turn with the hand would, by dp x K dp, as stiff as (kx - ky) |dp|^2, which no
// device can be promised to bear.
// Where all axes are alike, J' phi = phi and this is what is computed without any of it. Turned by
// theta about its stiffest axis k1, U is convex about the others up to theta^2 = 6 k / (k1 + k), k
// the softest of them, at least: a contact that holds the tool turned further may let it swing
// round. Frames: W; about the origin of G. RT: yes, about 0.2 us.
#pragma once

#include "core/contact/string_elimination.h"
#include "core/contact/virtual_coupling.h"

namespace hapticd {

/// The stiffness with these axes: N/m along x, y, z of W, and N m/rad about x, y, z of the tool,
/// all > 0. Three alike and three alike are one kt and one length, to the bit of kt and kr.
[[nodiscard]] HD_REALTIME CouplingStiffness coupling_of_axes(const Vector3& along_W,
                                                             const Vector3& about_G) noexcept;

/// The same stiffness, its shares such that one of each three is 1.
[[nodiscard]] HD_REALTIME CouplingStiffness normalised(const CouplingStiffness& stiffness) noexcept;

/// The three below where axes differ; they hold for all.
namespace axes {
[[nodiscard]] HD_REALTIME double energy(const CouplingStiffness& stiffness, const Quaternion& q_WH,
                                        const PoseError& error_GH) noexcept;
[[nodiscard]] HD_REALTIME Wrench pull(const CouplingStiffness& stiffness, const Quaternion& q_WH,
                                      const PoseError& error_GH) noexcept;
[[nodiscard]] HD_REALTIME PoseError stretch(const CouplingStiffness& stiffness,
                                            const Quaternion& q_WH, const PoseError& error_GH,
                                            const Wrench& F_G_W) noexcept;
}  // namespace axes

/// U, J, of the error of G to a hand that is turned as `q_WH`.
[[nodiscard]] inline double coupling_energy(const CouplingStiffness& stiffness,
                                            const Quaternion& q_WH,
                                            const PoseError& error_GH) noexcept {
  if (stiffness.per_axis) return axes::energy(stiffness, q_WH, error_GH);
  return 0.5 * (stiffness.kt * error_GH.dp.squaredNorm() +
                stiffness.kr() * error_GH.dtheta.squaredNorm());
}

/// What the coupling does to G there.
[[nodiscard]] inline Wrench coupling_pull(const CouplingStiffness& stiffness,
                                          const Quaternion& q_WH,
                                          const PoseError& error_GH) noexcept {
  if (stiffness.per_axis) return axes::pull(stiffness, q_WH, error_GH);
  return {stiffness.kt * error_GH.dp, stiffness.kr() * error_GH.dtheta};
}

/// The error at which the coupling, with J as it is at `error_GH`, would hold G against `F_G_W`.
[[nodiscard]] inline PoseError stretch_under(const CouplingStiffness& stiffness,
                                             const Quaternion& q_WH, const PoseError& error_GH,
                                             const Wrench& F_G_W) noexcept {
  if (stiffness.per_axis) return axes::stretch(stiffness, q_WH, error_GH, F_G_W);
  return {-F_G_W.f / stiffness.kt, -F_G_W.t / stiffness.kr()};
}

/// U of that error, J.
[[nodiscard]] inline double energy_under(const CouplingStiffness& stiffness, const Quaternion& q_WH,
                                         const PoseError& error_GH, const Wrench& F_G_W) noexcept {
  if (stiffness.per_axis) {
    return axes::energy(stiffness, q_WH, axes::stretch(stiffness, q_WH, error_GH, F_G_W));
  }
  return 0.5 * (F_G_W.f.squaredNorm() / stiffness.kt + F_G_W.t.squaredNorm() / stiffness.kr());
}

/// How far `force` (N, along the unit vector `nhat_W`) takes the hand that way, m.
[[nodiscard]] inline double depth_under(const CouplingStiffness& stiffness, double force,
                                        const Vector3& nhat_W) noexcept {
  if (!stiffness.per_axis) return force / stiffness.kt;
  return force * nhat_W.dot(nhat_W.cwiseQuotient(stiffness.along_W()));
}

/// Largest rotational stiffness of axes that differ, at any angle up to half a turn, N m/rad: the
/// Hessian of U is linear in Kr, and (pi/2)^2 for the worst of shares 0 and 1.
[[nodiscard]] HD_REALTIME double stiffest_rotation(const CouplingStiffness& stiffness) noexcept;

/// Units of rotation in which J' Kr_W J is the identity, dtheta = T z, and what the Hessian of U
/// has beyond it, in them.
struct RotationUnits {
  Matrix3 T;
  Matrix3 inverse;
  Matrix3 beyond;
};
[[nodiscard]] HD_REALTIME RotationUnits rotation_units(const CouplingStiffness& stiffness,
                                                       const Quaternion& q_WH,
                                                       const PoseError& error_GH) noexcept;

/// H in the units of rotation, before it is scaled.
HD_REALTIME void change_rotation(const Matrix3& T, std::size_t unknowns, ArrowMatrix& H) noexcept;

}  // namespace hapticd
