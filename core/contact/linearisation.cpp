// Second derivatives of the signed distances, of the rotation energy and of the strings. See
// linearisation.h. RT: yes.
#include "core/contact/linearisation.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/math/elementary.h"

namespace hapticd {
namespace {

/// How a point of the tool moves against a string or body: columns of the Jacobian of [dp; dtheta;
/// dv; du] that are not zero, in the order of the unknowns.
struct PointJacobian {
  static constexpr std::size_t kColumns = kToolDof + 2 + 3 * kMaxSoftParts;
  std::array<Vector3, kColumns> column;
  std::array<std::size_t, kColumns> unknown;
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
}

/// Lets the string move against the point by `share` of its deflection.
void add_string(const StringBlock& block, double share, PointJacobian& J) noexcept {
  if (block.unknown < 0) return;
  const auto first = static_cast<std::size_t>(block.unknown);
  J.column[J.count] = -share * block.radial_W;
  J.unknown[J.count++] = first;
  J.column[J.count] = -share * block.tangential_W;
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

/// Tool and obstacles between which the pairs that bear force are evaluated.
struct Shapes {
  const ToolView& tool;
  const ObstaclesView& obstacles;
};

/// `factor` times how the normal of a contact turns as the centre of the tool's sphere, of radius
/// `r`, moves; nothing where that is inside the obstacle's axis or centre.
std::optional<Matrix3> scaled_curvature(const Contact& contact, const Shapes& shapes, double r,
                                        double factor) noexcept {
  if (is_blend(contact.key)) {
    return factor * blend_curvature(contact.key, shapes.tool, shapes.obstacles);
  }
  const RoundObstacle obstacle = round_obstacle(contact, shapes.tool, shapes.obstacles);
  // From the obstacle's axis or centre to that of the tool's sphere.
  const double distance = contact.gap + r + obstacle.r;
  if (!(distance > 0.0)) return std::nullopt;
  const Vector3& n = contact.nhat_OG_W;
  Matrix3 round = Matrix3::Identity() - n * n.transpose();
  round -= obstacle.axis_W * obstacle.axis_W.transpose();
  return (factor / distance) * round;
}

/// H -= multiplier times the Hessian of the signed distance of one pair.
void subtract_curvature(const ContactView& view, const Shapes& shapes, const ActivePair& pair,
                        ArrowMatrix& H) noexcept {
  const auto& [input, state] = view.at();
  const Contact contact = evaluate_contact(pair.key, shapes.tool, shapes.obstacles);
  const double r = tree_sphere(input.tool, pair.key.tool_sphere).r;
  // The centre moves by dp - [a] dtheta + dv - share du; where the obstacle is round that costs
  // |v|^2 / (2 distance).
  const std::optional<Matrix3> curvature = scaled_curvature(contact, shapes, r, -pair.multiplier);
  if (!curvature) return;
  const Vector3& n = contact.nhat_OG_W;
  const Vector3 a = contact.p_WC + r * n - state.X_WG.p;
  PointJacobian J = point_jacobian(a);
  const int p = find_part(input.parts, state.parts, pair.key.tool_sphere);
  const PartBlock* part = p >= 0 ? &view.parts.block(static_cast<std::size_t>(p)) : nullptr;
  if (part != nullptr) add_part(*part, 1.0, J);
  if (const int s = find_touched(state.touched, pair.key); s >= 0) {
    const auto k = static_cast<std::size_t>(s);
    add_string(view.strings.block(k), deflection_share(state.touched[k].bend, contact.lambda), J);
  }
  add_quadratic(J, *curvature, H);
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

/// The tool with its soft parts, as they move the place `p_GC_W` of a string's contact.
PointJacobian contact_jacobian(const ContactView& view, const StringBlock& block,
                               const Vector3& p_GC_W) noexcept {
  PointJacobian J = point_jacobian(p_GC_W);
  for (std::size_t p = 0; p < block.parts; ++p) {
    add_part(view.parts.block(p), block.part_share[p], J);
  }
  return J;
}

/// The lateral force, and how it changes as the vertex goes along with the tool, and across.
void add_lateral(const ContactView& view, const StringBlock& block, ArrowMatrix& H,
                 Unknowns& downhill) noexcept {
  const PointJacobian J = contact_jacobian(view, block, block.p_GS_W);
  std::array<double, PointJacobian::kColumns> along;
  for (std::size_t i = 0; i < J.count; ++i) {
    along[i] = J.column[i].dot(block.axis_W);
    downhill[J.unknown[i]] += block.lateral_force * along[i];
    for (std::size_t j = 0; j <= i; ++j) {
      H(J.unknown[i], J.unknown[j]) += block.axial_stiffness * along[i] * along[j];
    }
    if (block.unknown < 0) continue;
    H(static_cast<std::size_t>(block.unknown), J.unknown[i]) += block.mixed_stiffness * along[i];
  }
}

/// Friction and lateral force of the touched strings: their downhill gradient and stiffness.
void add_tangential(const ContactView& view, ArrowMatrix& H, Unknowns& downhill) noexcept {
  for (std::size_t k = 0; k < view.state.touched.size(); ++k) {
    const StringBlock& block = view.strings.block(k);
    if (block.lateral_force != 0.0) add_lateral(view, block, H, downhill);
    if (block.slip_stiffness == 0.0) continue;
    const StringBend& bend = view.state.touched[k].bend;
    PointJacobian J = contact_jacobian(view, block, block.p_GC_W);
    add_string(block, block.unknown < 0 ? 0.0 : deflection_share(bend, block.lambda), J);
    const Vector3& n = block.nhat_W;
    const Vector3 friction = -block.slip_stiffness * block.slip_W;
    for (std::size_t i = 0; i < J.count; ++i) {
      downhill[J.unknown[i]] += J.column[i].dot(friction);
    }
    const Vector3& s = block.slipping_W;
    add_quadratic(
        J, block.slip_stiffness * (Matrix3::Identity() - n * n.transpose() - s * s.transpose()), H);
  }
}

/// Stick anchors on rigid objects.
void add_grips(const ContactView& view, ArrowMatrix& H, Unknowns& downhill) noexcept {
  for (std::size_t k = 0; k < view.state.grips.size(); ++k) {
    const GripBlock& block = view.friction.block(k);
    if (block.slip_stiffness == 0.0) continue;
    PointJacobian J = point_jacobian(block.p_GC_W);
    for (std::size_t p = 0; p < block.parts; ++p) {
      add_part(view.parts.block(p), block.part_share[p], J);
    }
    const Vector3& n = block.nhat_W;
    const Vector3 f = -block.slip_stiffness * block.slip_W;
    for (std::size_t i = 0; i < J.count; ++i) downhill[J.unknown[i]] += J.column[i].dot(f);
    const Vector3& s = block.slipping_W;
    add_quadratic(
        J, block.slip_stiffness * (Matrix3::Identity() - n * n.transpose() - s * s.transpose()), H);
  }
}

/// Units in which G and K are the identity, and the downhill gradient of what lies along one
/// unknown alone.
void measure(const ContactView& view, const PoseError& error_GH, UnknownScale& scale) noexcept {
  const CouplingStiffness& stiffness = view.input.stiffness;
  const Wrench pull = coupling_pull(stiffness, view.input.X_WH.q, error_GH);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<Eigen::Index>(k);
    scale.inverse_root[k] = 1.0 / std::sqrt(stiffness.kt);
    scale.inverse_root[k + 3] = 1.0 / std::sqrt(stiffness.kr());
    scale.downhill[k] = pull.f[axis];
    scale.downhill[k + 3] = pull.t[axis];
    if (!stiffness.per_axis) continue;
    scale.inverse_root[k] /= std::sqrt(stiffness.shares.along_W[axis]);
    scale.inverse_root[k + 3] = 1.0;
  }
  view.strings.measure(view.state, scale);
  view.parts.measure(view.state, scale);
}

/// Unknowns that stay in one matrix: all, or where too many strings yield those before theirs.
std::size_t core_unknowns(const ContactState& state, std::size_t unknowns) noexcept {
  std::size_t yielding = 0;
  for (const TouchedString& string : state.touched) yielding += string.yields ? 1 : 0;
  return yielding > kMaxDenseStrings ? unknowns - 2 * yielding : unknowns;
}

}  // namespace

void Linearisation::find_target(Unknowns& downhill) noexcept {
  const std::size_t core = basis_.size;
  const std::span<const EliminatedString> strings = eliminated();
  for (std::size_t k = 0; k < strings.size(); ++k) {
    const EliminatedString& string = strings[k];
    const std::size_t first = core + 2 * k;
    for (std::size_t b = 0; b < 2; ++b) {
      target_z_[first + b] =
          string.root[0][b] * downhill[first] + string.root[1][b] * downhill[first + 1];
    }
    for (std::size_t j = 0; j < core; ++j) {
      downhill[j] +=
          string.follow[0][j] * downhill[first] + string.follow[1][j] * downhill[first + 1];
    }
  }
  for (std::size_t j = 0; j < core; ++j) {
    double sum = 0.0;
    for (std::size_t i = 0; i < core; ++i) sum += basis_(i, j) * downhill[i];
    target_z_[j] = sum;
  }
}

// Rotation about the axes of W again.
void Linearisation::leave_units(const RotationUnits& units, std::size_t strings) noexcept {
  for (std::size_t k = 0; k < basis_.size; ++k) {
    const Vector3 turn = units.T * Vector3(basis_(3, k), basis_(4, k), basis_(5, k));
    for (std::size_t j = 0; j < 3; ++j) basis_(j + 3, k) = turn[static_cast<Eigen::Index>(j)];
  }
  for (EliminatedString& string : std::span(strings_).first(strings)) {
    for (auto& follow : string.follow) {
      const Vector3 turn = units.inverse.transpose() * Vector3(follow[3], follow[4], follow[5]);
      for (std::size_t j = 0; j < 3; ++j) follow[j + 3] = turn[static_cast<Eigen::Index>(j)];
    }
  }
}

void Linearisation::build(const ContactView& view, const PoseError& error_GH,
                          int unknowns) noexcept {
  const auto n = static_cast<std::size_t>(unknowns);
  UnknownScale scale;
  measure(view, error_GH, scale);

  ArrowMatrix H(core_unknowns(view.state, n), n);
  const BentObstacles bent(view.input.obstacles, view.state.touched);
  const ToolShape shape(view.input.parts, view.state.parts);
  const ObstaclesView obstacles = bent.view();
  const ToolView tool{view.input.tool, view.state.X_WG, shape.view()};
  for (int k = 0; k < view.state.active_count; ++k) {
    subtract_curvature(view, {tool, obstacles}, view.state.active[static_cast<std::size_t>(k)], H);
  }
  add_tangential(view, H, scale.downhill);
  add_grips(view, H, scale.downhill);
  const CouplingStiffness& stiffness = view.input.stiffness;
  RotationUnits units;
  if (stiffness.per_axis) {
    units = rotation_units(stiffness, view.input.X_WH.q, error_GH);
    change_rotation(units.T, n, H);
  }
  const Matrix3 rotation = stiffness.per_axis ? Matrix3(Matrix3::Identity() + units.beyond)
                                              : rotation_hessian(error_GH.dtheta);
  H.scale(scale.inverse_root);
  for (std::size_t i = 0; i < H.core.size; ++i) H(i, i) += i >= 3 && i < 6 ? 0.0 : 1.0;
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      H(static_cast<std::size_t>(i + 3), static_cast<std::size_t>(j + 3)) += rotation(i, j);
    }
  }

  unknowns_ = n;
  H.eliminate(kMinStiffnessShare, strings_);
  inverse_square_root(H.core, kMinStiffnessShare, basis_);
  for (std::size_t i = 0; i < basis_.size; ++i) {
    for (std::size_t j = 0; j < basis_.size; ++j) basis_(i, j) *= scale.inverse_root[i];
  }
  unscale(scale.inverse_root, basis_.size, std::span(strings_).first(H.strings()));
  if (stiffness.per_axis) leave_units(units, H.strings());
  find_target(scale.downhill);
}

// A string that is eliminated: its own motion, and with what the core does to it.
void Linearisation::add_eliminated(const StringTerm& term, QpProblem& problem) const noexcept {
  const std::size_t first = term.unknown;
  const EliminatedString& string = eliminated()[(first - basis_.size) / 2];
  for (std::size_t b = 0; b < 2; ++b) {
    problem.row[first + b][term.row] =
        string.root[0][b] * term.radial + string.root[1][b] * term.tangential;
  }
  std::array<double, kMaxCoreUnknowns> follow;
  for (std::size_t j = 0; j < basis_.size; ++j) {
    follow[j] = string.follow[0][j] * term.radial + string.follow[1][j] * term.tangential;
  }
  for (std::size_t k = 0; k < basis_.size; ++k) {
    double sum = problem.row[k][term.row];
    for (std::size_t j = 0; j < basis_.size; ++j) sum += basis_(j, k) * follow[j];
    problem.row[k][term.row] = sum;
  }
}

void Linearisation::add_string(const StringTerm& term, QpProblem& problem) const noexcept {
  if (term.unknown >= basis_.size) {
    add_eliminated(term, problem);
    return;
  }
  for (std::size_t k = 0; k < basis_.size; ++k) {
    problem.row[k][term.row] +=
        basis_(term.unknown, k) * term.radial + basis_(term.unknown + 1, k) * term.tangential;
  }
}

void Linearisation::set_objective(QpProblem& problem) const noexcept {
  problem.unknowns = static_cast<int>(unknowns_);
  for (std::size_t k = 0; k < unknowns_; ++k) {
    problem.weight[k] = 1.0;
    problem.target[k] = target_z_[k];
  }
}

void Linearisation::find_unknowns(const QpSolution& solution, Unknowns& y) const noexcept {
  for (std::size_t i = 0; i < basis_.size; ++i) {
    double sum = 0.0;
    for (std::size_t k = 0; k < basis_.size; ++k) sum += basis_(i, k) * solution.x[k];
    y[i] = sum;
  }
  const std::span<const EliminatedString> strings = eliminated();
  for (std::size_t s = 0; s < strings.size(); ++s) {
    const std::size_t first = basis_.size + 2 * s;
    for (std::size_t a = 0; a < 2; ++a) {
      double sum =
          strings[s].root[a][0] * solution.x[first] + strings[s].root[a][1] * solution.x[first + 1];
      for (std::size_t j = 0; j < basis_.size; ++j) sum += strings[s].follow[a][j] * y[j];
      y[first + a] = sum;
    }
  }
}

}  // namespace hapticd
