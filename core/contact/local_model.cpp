// Second derivatives of the signed distances, of the rotation energy and of the strings. See
// local_model.h. RT: yes.
#include "core/contact/local_model.h"

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"

namespace hapticd {
namespace {

/// What the present linearisation knows of strings and soft parts.
struct Models {
  const StringBlocks& holds;
  const PartBlocks& parts;
};

/// How a point of the tool moves against a string or body: columns of the Jacobian of [dp; dtheta;
/// dv; du] that are not zero, in the order of the unknowns.
struct PointJacobian {
  static constexpr std::size_t kColumns = kToolDof + 2 + 3 * kMaxSoftParts;
  std::array<Vector3, kColumns> column;
  std::array<std::size_t, kColumns> unknown;
  std::size_t of_tool = kToolDof;  ///< columns that move the tool; those of the string follow
  std::size_t count = kToolDof;
};

/// Lets the part move the point by `share` of its motion; parts in order, before strings.
void add_part(const PartBlock& part, double share, PointJacobian& J) noexcept {
  if (part.unknown < 0 || share == 0.0) return;
  for (std::size_t k = 0; k < 3; ++k) {
    J.column[J.count] = Vector3::Zero();
    J.column[J.count][static_cast<Eigen::Index>(k)] = share;
    J.unknown[J.count++] = static_cast<std::size_t>(part.unknown) + k;
  }
  J.of_tool = J.count;
}

/// Lets the string move against the point by `share` of its deflection.
void add_string(const StringBlock& hold, double share, PointJacobian& J) noexcept {
  if (hold.unknown < 0) return;
  const auto first = static_cast<std::size_t>(hold.unknown);
  J.column[J.count] = -share * hold.radial_W;
  J.unknown[J.count++] = first;
  J.column[J.count] = -share * hold.tangential_W;
  J.unknown[J.count++] = first + 1;
}

PointJacobian point_jacobian(const Vector3& p_GC_W) noexcept {
  PointJacobian out;
  for (std::size_t k = 0; k < 3; ++k) {
    Vector3 unit = Vector3::Zero();
    unit[static_cast<Eigen::Index>(k)] = 1.0;
    out.column[k] = unit;
    out.column[k + 3] = unit.cross(p_GC_W);
    out.unknown[k] = k;
    out.unknown[k + 3] = k + 3;
  }
  return out;
}

/// H += J' A J, lower triangle.
void add_quadratic(const PointJacobian& J, const Matrix3& A, ArrowMatrix& H) noexcept {
  for (std::size_t i = 0; i < J.count; ++i) {
    const Vector3 Aj = A * J.column[i];
    for (std::size_t j = 0; j <= i; ++j) H(J.unknown[i], J.unknown[j]) += J.column[j].dot(Aj);
  }
}

/// Distance from the obstacle's axis or centre to the tool sphere's centre, and the directions in
/// which the obstacle is round: all but the normal, and but the axis along a capsule's straight
/// part.
struct RoundContact {
  double distance;
  Matrix3 round;
};

RoundContact round_contact(const ContactInput& input, const ObstaclesView& obstacles,
                           const ContactKey& key, const Contact& contact, double r) noexcept {
  RoundContact out;
  const Vector3& n = contact.nhat_OG_W;
  out.round = Matrix3::Identity() - n * n.transpose();
  if (key.kind == ObstacleKind::kBody) {
    const auto o = static_cast<std::size_t>(key.obstacle);
    out.distance =
        contact.gap + r + tree_sphere(input.obstacles.bodies[o].tree, key.obstacle_sphere).r;
    return out;
  }
  const Capsule capsule = segment_of(obstacles, key.obstacle, key.obstacle_sphere).capsule_W;
  out.distance = contact.gap + r + capsule.r;
  if (contact.lambda > 0.0 && contact.lambda < 1.0) {
    const Vector3 axis = (capsule.p_B - capsule.p_A).normalized();
    out.round -= axis * axis.transpose();
  }
  return out;
}

/// A soft part turns with the tool: H -= the Hessian of f . dtheta x dv.
void subtract_turning(const PartBlock& part, const Vector3& f, ArrowMatrix& H) noexcept {
  const auto v = static_cast<std::size_t>(part.unknown);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const double component = f[static_cast<Eigen::Index>((i + 2) % 3)];
    H(v + j, i + 3) -= component;
    H(v + i, j + 3) += component;
  }
}

/// H -= multiplier times the Hessian of the signed distance of one pair.
void subtract_curvature(const ContactInput& input, const ObstaclesView& obstacles,
                        const ContactState& state, const Models& models, const ToolShape& shape,
                        const ActivePair& pair, ArrowMatrix& H) noexcept {
  const Contact contact =
      evaluate_contact(pair.key, input.tool, state.X_WG, obstacles, shape.view());
  const double r = tree_sphere(input.tool, pair.key.tool_sphere).r;
  const RoundContact geometry = round_contact(input, obstacles, pair.key, contact, r);
  if (!(geometry.distance > 0.0)) return;
  const Vector3& n = contact.nhat_OG_W;
  const Vector3 a = contact.p_WC + r * n - state.X_WG.p;
  PointJacobian J = point_jacobian(a);
  const int p = find_part(input.parts, state.parts, pair.key.tool_sphere);
  const PartBlock* part = p >= 0 ? &models.parts[static_cast<std::size_t>(p)] : nullptr;
  if (part != nullptr) add_part(*part, 1.0, J);
  if (const int h = find_touched(state.touched, pair.key); h >= 0) {
    const auto k = static_cast<std::size_t>(h);
    add_string(models.holds[k], deflection_share(state.touched[k].bend, contact.lambda), J);
  }
  // The centre moves by dp - [a] dtheta + dv - share du; where the obstacle is round that costs
  // |v|^2 / (2 distance).
  add_quadratic(J, (-pair.multiplier / geometry.distance) * geometry.round, H);
  if (part != nullptr && part->unknown >= 0) subtract_turning(*part, pair.multiplier * n, H);
  // Second order of the rotation itself: n . dtheta x (dtheta x a).
  const double along = n.dot(a);
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      const double second = 0.5 * (n[i] * a[j] + n[j] * a[i]) - (i == j ? along : 0.0);
      H(static_cast<std::size_t>(i + 3), static_cast<std::size_t>(j + 3)) -=
          pair.multiplier * second;
    }
  }
}

/// Hessian of 1/2 |log R|^2: 1 along the rotation axis, (phi/2) cot(phi/2) across it; kept positive
/// past pi.
Matrix3 rotation_hessian(const Vector3& phi) noexcept {
  const double angle = phi.norm();
  if (!(angle > 1e-4)) return Matrix3::Identity();
  const Vector3 axis = phi / angle;
  const SinCos half = sin_cos(0.5 * angle);
  const double across = std::max(kMinStiffnessShare, 0.5 * angle * half.cos / half.sin);
  return across * Matrix3::Identity() + (1.0 - across) * axis * axis.transpose();
}

/// Downhill gradient, stiffness and friction of the held strings.
void add_holds(const ContactState& state, const Models& models, ArrowMatrix& H,
               std::array<double, kMaxQpUnknowns>& downhill) noexcept {
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    const StringBlock& hold = models.holds[k];
    if (hold.unknown >= 0) {
      const auto first = static_cast<std::size_t>(hold.unknown);
      downhill[first] = -hold.force;
      downhill[first + 1] = 0.0;
    }
    if (hold.lateral_force == 0.0 && hold.slip_stiffness == 0.0) continue;
    const StringBend& bend = state.touched[k].bend;
    const double share = hold.unknown < 0 ? 0.0 : deflection_share(bend, hold.lambda);
    PointJacobian J = point_jacobian(hold.p_GC_W);
    for (std::size_t p = 0; p < hold.parts; ++p) add_part(models.parts[p], hold.part_share[p], J);
    add_string(hold, share, J);
    const Vector3& n = hold.nhat_W;
    const Vector3 friction = -hold.slip_stiffness * hold.slip_W;
    const Vector3 lateral = hold.lateral_force * hold.axis_W;
    // The string's ends hold it along its axis: there only the tool gains.
    for (std::size_t i = 0; i < J.count; ++i) {
      downhill[J.unknown[i]] += J.column[i].dot(i < J.of_tool ? friction + lateral : friction);
    }
    add_quadratic(J, hold.slip_stiffness * (Matrix3::Identity() - n * n.transpose()), H);
  }
}

/// Units in which G and K are the identity, and the downhill gradient of what lies along one
/// unknown alone: of the coupling and of the soft parts.
void measure(const ContactInput& input, const ContactState& state, const PoseError& error_GH,
             const Models& models, std::array<double, kMaxQpUnknowns>& inverse_root,
             std::array<double, kMaxQpUnknowns>& downhill) noexcept {
  for (std::size_t k = 0; k < 3; ++k) {
    inverse_root[k] = 1.0 / std::sqrt(input.stiffness.kt);
    inverse_root[k + 3] = 1.0 / std::sqrt(input.stiffness.kr());
    downhill[k] = input.stiffness.kt * error_GH.dp[static_cast<Eigen::Index>(k)];
    downhill[k + 3] = input.stiffness.kr() * error_GH.dtheta[static_cast<Eigen::Index>(k)];
  }
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    if (models.holds[k].unknown < 0) continue;
    const auto first = static_cast<std::size_t>(models.holds[k].unknown);
    inverse_root[first] = 1.0 / std::sqrt(models.holds[k].radial_stiffness);
    inverse_root[first + 1] = 1.0 / std::sqrt(models.holds[k].tangential_stiffness);
  }
  for (std::size_t k = 0; k < state.parts.size(); ++k) {
    if (models.parts[k].unknown < 0) continue;
    const auto first = static_cast<std::size_t>(models.parts[k].unknown);
    for (std::size_t i = 0; i < 3; ++i) {
      inverse_root[first + i] = 1.0 / std::sqrt(models.parts[k].stiffness);
      downhill[first + i] = models.parts[k].pull_W[static_cast<Eigen::Index>(i)];
    }
  }
}

/// Unknowns that stay in one matrix: all, or where too many strings yield those before theirs.
std::size_t core_unknowns(const ContactState& state, std::size_t unknowns) noexcept {
  std::size_t yielding = 0;
  for (const TouchedString& hold : state.touched) yielding += hold.yields ? 1 : 0;
  return yielding > kMaxDenseStrings ? unknowns - 2 * yielding : unknowns;
}

/// The unconstrained minimiser, from the downhill gradient.
void find_target(std::array<double, kMaxQpUnknowns>& downhill, LocalModel& model) noexcept {
  const std::size_t core = model.basis.size;
  const std::span<const EliminatedString> strings = model.eliminated();
  for (std::size_t k = 0; k < strings.size(); ++k) {
    const EliminatedString& string = strings[k];
    const std::size_t first = core + 2 * k;
    for (std::size_t b = 0; b < 2; ++b) {
      model.target_z[first + b] =
          string.root[0][b] * downhill[first] + string.root[1][b] * downhill[first + 1];
    }
    for (std::size_t j = 0; j < core; ++j) {
      downhill[j] +=
          string.follow[0][j] * downhill[first] + string.follow[1][j] * downhill[first + 1];
    }
  }
  for (std::size_t j = 0; j < core; ++j) {
    double sum = 0.0;
    for (std::size_t i = 0; i < core; ++i) sum += model.basis(i, j) * downhill[i];
    model.target_z[j] = sum;
  }
}

}  // namespace

void build_local_model(const ContactInput& input, const ContactState& state,
                       const PoseError& error_GH, const StringBlocks& models,
                       const PartBlocks& parts, int unknowns, LocalModel& model) noexcept {
  const auto n = static_cast<std::size_t>(unknowns);
  std::array<double, kMaxQpUnknowns> inverse_root;
  std::array<double, kMaxQpUnknowns> downhill;
  measure(input, state, error_GH, {models, parts}, inverse_root, downhill);

  ArrowMatrix H(core_unknowns(state, n), n);
  const Models yielding{models, parts};
  const BentObstacles bent(input.obstacles, state.touched);
  const ToolShape shape(input.parts, state.parts);
  for (int k = 0; k < state.active_count; ++k) {
    subtract_curvature(input, bent.view(), state, yielding, shape,
                       state.active[static_cast<std::size_t>(k)], H);
  }
  add_holds(state, yielding, H, downhill);
  const Matrix3 rotation = rotation_hessian(error_GH.dtheta);
  H.scale(inverse_root);
  for (std::size_t i = 0; i < H.core.size; ++i) H(i, i) += i >= 3 && i < 6 ? 0.0 : 1.0;
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      H(static_cast<std::size_t>(i + 3), static_cast<std::size_t>(j + 3)) += rotation(i, j);
    }
  }

  model.unknowns = n;
  H.eliminate(kMinStiffnessShare, model.strings);
  inverse_square_root(H.core, kMinStiffnessShare, model.basis);
  for (std::size_t i = 0; i < model.basis.size; ++i) {
    for (std::size_t j = 0; j < model.basis.size; ++j) model.basis(i, j) *= inverse_root[i];
  }
  unscale(inverse_root, model.basis.size, std::span(model.strings).first(H.strings()));
  find_target(downhill, model);
}

}  // namespace hapticd
