// Error and motion of the graphic tool. See virtual_coupling.h. RT: yes.
#include "core/contact/virtual_coupling.h"

#include "core/math/rotation.h"

namespace hapticd {

PoseError coupling_error(const Pose& X_WG, const Pose& X_WH,
                         const Vector3& phi_reference) noexcept {
  const Quaternion q_GH_W = X_WH.q * X_WG.q.conjugate();
  return {X_WH.p - X_WG.p, log_rotation_near(q_GH_W, phi_reference, kBranchLatchAngle)};
}

ToolMotion motion_between(const Pose& X_from, const Pose& X_to) noexcept {
  return closing(coupling_error(X_from, X_to, Vector3::Zero()));
}

Pose moved(const Pose& X_WG, const ToolMotion& step) noexcept {
  return {renormalised(exp_rotation(step.dtheta) * X_WG.q), X_WG.p + step.dp};
}

}  // namespace hapticd
