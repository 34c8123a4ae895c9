// Second derivatives of the signed distances and of the rotation energy. See local_model.h. RT:
// yes.
#include "core/rendering/local_model.h"

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"
#include "core/math/symmetric_matrix.h"

namespace hapticd {
namespace {

Matrix3 cross_matrix(const Vector3& v) noexcept {
  Matrix3 m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

/// Distance from the obstacle's axis or centre to the tool sphere's centre, that centre, and the
/// directions in which the obstacle is round: all but the normal, and but the axis along a
/// capsule's straight part.
struct RoundContact {
  Vector3 p_GC_W;
  double distance;
  Matrix3 round;
};

RoundContact round_contact(const OptimiserInput& input, const ContactKey& key,
                           const Contact& contact, const Vector3& p_WG) noexcept {
  const double r = tree_sphere(input.tool, key.tool_sphere).r;
  RoundContact out;
  const Vector3& n = contact.nhat_OG_W;
  out.p_GC_W = contact.p_WC + r * n - p_WG;
  out.round = Matrix3::Identity() - n * n.transpose();
  const auto o = static_cast<std::size_t>(key.obstacle);
  if (key.kind == ObstacleKind::kBody) {
    out.distance =
        contact.gap + r + tree_sphere(input.obstacles.bodies[o].tree, key.obstacle_sphere).r;
    return out;
  }
  const Capsule& capsule = input.obstacles.capsules_W[o];
  out.distance = contact.gap + r + capsule.r;
  if (contact.lambda > 0.0 && contact.lambda < 1.0) {
    const Vector3 axis = (capsule.p_B - capsule.p_A).normalized();
    out.round -= axis * axis.transpose();
  }
  return out;
}

/// Hessian of the signed distance of one pair with respect to [dp; dtheta].
Matrix6 gap_hessian(const RoundContact& c, const Vector3& n) noexcept {
  // The centre moves by dp - [a] dtheta; where the obstacle is round that costs |v|^2 / (2
  // distance).
  const Matrix3 a = cross_matrix(c.p_GC_W);
  const Matrix3 A = c.round / c.distance;
  const Matrix3 Aa = A * a;
  Matrix6 hessian;
  hessian.topLeftCorner<3, 3>() = A;
  hessian.topRightCorner<3, 3>() = -Aa;
  hessian.bottomLeftCorner<3, 3>() = -Aa.transpose();
  hessian.bottomRightCorner<3, 3>() = a.transpose() * Aa;
  // Second order of the rotation itself: n . dtheta x (dtheta x a).
  const Matrix3 outer = n * c.p_GC_W.transpose();
  hessian.bottomRightCorner<3, 3>() +=
      0.5 * (outer + outer.transpose()) - n.dot(c.p_GC_W) * Matrix3::Identity();
  return hessian;
}

/// Hessian of 1/2 |log R|^2: 1 along the rotation axis, (phi/2) cot(phi/2) across it; kept positive
/// past pi.
Matrix3 rotation_hessian(const Vector3& phi) noexcept {
  const double angle = phi.norm();
  if (!(angle > 1e-4)) return Matrix3::Identity();
  const Vector3 axis = phi / angle;
  const SinCos half = sin_cos(0.5 * angle);
  const double across = std::max(kLeastStiffnessShare, 0.5 * angle * half.cos / half.sin);
  return across * Matrix3::Identity() + (1.0 - across) * axis * axis.transpose();
}

}  // namespace

LocalModel local_model(const OptimiserInput& input, const OptimiserState& state,
                       const ToolStep& e) noexcept {
  // Everything in units where G is the identity.
  Vector6 inverse_root;
  inverse_root << Vector3::Constant(1.0 / std::sqrt(input.stiffness.kt)),
      Vector3::Constant(1.0 / std::sqrt(input.stiffness.kr()));
  Matrix6 stiff = Matrix6::Identity();
  stiff.bottomRightCorner<3, 3>() = rotation_hessian(e.dtheta);

  Matrix6 curvature = Matrix6::Zero();
  for (int k = 0; k < state.active_count; ++k) {
    const ActivePair& pair = state.active[static_cast<std::size_t>(k)];
    const Contact contact = evaluate_contact(pair.key, input.tool, state.X_WG, input.obstacles);
    const RoundContact geometry = round_contact(input, pair.key, contact, state.X_WG.p);
    if (!(geometry.distance > 0.0)) continue;
    curvature += pair.multiplier * gap_hessian(geometry, contact.nhat_OG_W);
  }
  curvature = inverse_root.asDiagonal() * curvature * inverse_root.asDiagonal();

  LocalModel model;
  model.basis =
      inverse_root.asDiagonal() * inverse_square_root(stiff - curvature, kLeastStiffnessShare);
  Vector6 gradient;
  gradient << input.stiffness.kt * e.dp, input.stiffness.kr() * e.dtheta;
  model.target_z = model.basis.transpose() * gradient;
  return model;
}

}  // namespace hapticd
