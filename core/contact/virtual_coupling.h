// The 6-D virtual coupling between haptic tool H (the hand) and graphic tool G (what is shown and
// touches): Eq. 5's metric
//   G = diag(kt, kt, kt, kr, kr, kr),  error e = (p_WH - p_WG, rotation vector of R_WH R_GW),
//   energy 1/2 |e|_G^2.
// Where its axes differ, translation is along those of W and rotation about the tool's own
// (coupling_axes.h). Error, step and wrench are taken about the origin of G, in W. RT: yes, about
// 50 ns.
#pragma once

#include "core/math/pose.h"
#include "core/math/realtime.h"
#include "core/math/wrench.h"

namespace hapticd {

/// How stiff each axis is, as a share of the stiffest: in (0, 1], one of each three is 1.
struct AxisShares {
  Vector3 along_W{1.0, 1.0, 1.0};  ///< translation, of kt
  Vector3 about_G{1.0, 1.0, 1.0};  ///< rotation, of kr; H has the same axes where it meets G
};

/// False where a share is not in (0, 1]: for numbers that come from a file.
[[nodiscard]] inline bool usable(const AxisShares& shares) noexcept {
  const auto fine = [](const Vector3& v) {
    return (v.array() > 0.0).all() && (v.array() <= 1.0).all();
  };
  return fine(shares.along_W) && fine(shares.about_G);
}

/// Stiffness of the coupling. `length` weighs rotation against translation: kr = kt length^2.
struct CouplingStiffness {
  double kt = 1000.0;     ///< N/m, > 0; of the stiffest axis
  double length = 0.032;  ///< m; in [3 mm, 1 m] where all axes are alike
  bool per_axis = false;  ///< the shares count; otherwise they are all 1
  AxisShares shares{};

  /// Rotational stiffness of the stiffest axis, N m/rad.
  [[nodiscard]] double kr() const noexcept { return kt * length * length; }
  /// Translational stiffness of each axis of W, N/m.
  [[nodiscard]] Vector3 along_W() const noexcept { return kt * shares.along_W; }
  /// Rotational stiffness of each axis of the tool, N m/rad.
  [[nodiscard]] Vector3 about_G() const noexcept { return kr() * shares.about_G; }
};

/// A small motion [dp; dtheta] of the graphic tool: translation of its origin (m) and rotation
/// vector (rad), both in W.
struct ToolMotion {
  Vector3 dp{0.0, 0.0, 0.0};
  Vector3 dtheta{0.0, 0.0, 0.0};
};

/// Error of the graphic tool's pose to the haptic tool's: how far G would have to move [m; rad],
/// about the origin of G, in W.
struct PoseError {
  Vector3 dp{0.0, 0.0, 0.0};
  Vector3 dtheta{0.0, 0.0, 0.0};
};

/// The motion that makes the error vanish.
[[nodiscard]] inline ToolMotion closing(const PoseError& error_GH) noexcept {
  return {error_GH.dp, error_GH.dtheta};
}

/// Angle up to which the rotation error stays on the branch it was on before it turns over to the
/// short way round, rad. Larger: the torque holds its direction longer past pi; below pi there
/// would be no latch at all.
inline constexpr double kBranchLatchAngle = 1.5 * 3.14159265358979323846;

/// Error of `X_WG` to the target `X_WH`; its rotation lies on the branch nearest to
/// `phi_reference` (the previous error).
[[nodiscard]] HD_REALTIME PoseError coupling_error(const Pose& X_WG, const Pose& X_WH,
                                                   const Vector3& phi_reference) noexcept;

/// The motion that takes `X_from` to `X_to`, the short way round.
[[nodiscard]] HD_REALTIME ToolMotion motion_between(const Pose& X_from, const Pose& X_to) noexcept;

/// Pose after `step`: translation added, rotation composed on the left, quaternion renormalised.
[[nodiscard]] HD_REALTIME Pose moved(const Pose& X_WG, const ToolMotion& step) noexcept;

/// Upper bound of the displacement of any tool point within `reach` (m) of the tool's origin, m.
[[nodiscard]] inline double displacement_bound(const ToolMotion& step, double reach) noexcept {
  return step.dp.norm() + step.dtheta.norm() * reach;
}

/// `step` times `factor`.
[[nodiscard]] inline ToolMotion scaled(const ToolMotion& step, double factor) noexcept {
  return {step.dp * factor, step.dtheta * factor};
}

}  // namespace hapticd
