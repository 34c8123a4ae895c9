// See string_row_truth.h.
#include "tests/core/contact/string_row_truth.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

namespace hapticd::test {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr int kMaxSteps = 300;
constexpr double kDifference = 1e-7;
/// Unbalanced force that counts as none, as a share of the hand's pull and N.
constexpr double kBalanced = 1e-9;
/// Share of the coupling's stiffness that a stable rest keeps against the strings' letting it slip.
constexpr double kStable = 0.2;
constexpr double kMinSlack = 0.1;

Matrix3 rotation_of(const Vector3& phi) {
  const double angle = phi.norm();
  if (angle == 0.0) return Matrix3::Identity();
  return Eigen::AngleAxisd(angle, phi / angle).toRotationMatrix();
}

/// Rotation vector of a rotation of less than half a turn.
Vector3 vector_of(const Matrix3& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

/// A string under its sphere.
struct Push {
  Vector3 force;
  double strength;
  double slack;  ///< share of the sphere's reach by which its centre is on its side of the axis
};

Push push_of(const StringRow& row, std::size_t k, const Vector3& centre) {
  const StringParameters& string = row.strings[k];
  const LawString law = law_string(string);
  const Vector3 o(0.0, centre.y() - string.p_WA[1], centre.z() - string.p_WA[2]);
  // Pressed from above: beyond the axis the direction goes on.
  const double side = o.y() >= 0.0 ? 1.0 : -1.0;
  const double distance = side * o.norm();
  const Vector3 n = o / distance;
  const auto reach = static_cast<long double>(row.tool[k].r + string.radius);
  const auto lambda =
      static_cast<long double>((centre.x() - string.p_WA[0]) / (string.p_WB[0] - string.p_WA[0]));
  long double vertex = reach - static_cast<long double>(distance);
  if (!(vertex > 0.0L)) return {Vector3::Zero(), 0.0, 1.0};
  for (int i = 0; i < 8; ++i) {
    vertex = sphere_rest(law, lambda, vertex, reach).height - static_cast<long double>(distance);
  }
  const auto kt = static_cast<long double>(row.stiffness.kt);
  const auto force = static_cast<double>(vertex_spring(law, lambda, vertex, kt).force /
                                         sphere_rest(law, lambda, vertex, reach).share);
  return {force * n, force, distance / static_cast<double>(reach)};
}

/// Force and torque that are not balanced; the rest of `rest` from its pose.
Vector6 unbalanced(const StringRow& row, const Vector3& p_WH, const Matrix3& R_WH,
                   const Vector6& pose, RowRest& rest) {
  rest.p_WG = pose.head<3>();
  rest.phi_WG = pose.tail<3>();
  const Matrix3 R_WG = rotation_of(rest.phi_WG);
  rest.F_H_W = Wrench{};
  rest.force.clear();
  for (std::size_t k = 0; k < row.strings.size(); ++k) {
    const Vector3 arm = R_WG * row.tool[k].p;
    const Push push = push_of(row, k, rest.p_WG + arm);
    rest.F_H_W.f += push.force;
    rest.F_H_W.t += arm.cross(push.force);
    rest.force.push_back(push.strength);
  }
  Vector6 out;
  out.head<3>() = rest.F_H_W.f + row.stiffness.kt * (p_WH - rest.p_WG);
  out.tail<3>() = (rest.F_H_W.t + row.stiffness.kr() * vector_of(R_WH * R_WG.transpose())) /
                  row.stiffness.length;
  return out;
}

/// Near the axis and beyond it a string without friction slips round the sphere.
bool slips(const StringRow& row, const RowRest& rest) {
  const Matrix3 R_WG = rotation_of(rest.phi_WG);
  for (std::size_t k = 0; k < row.strings.size(); ++k) {
    if (push_of(row, k, rest.p_WG + R_WG * row.tool[k].p).slack < kMinSlack) return true;
  }
  return false;
}

/// Minus the derivative of what is not balanced, rotations measured as ways of the coupling's
/// length.
Matrix6 stiffness_at(const StringRow& row, const Vector3& p_WH, const Matrix3& R_WH,
                     const Vector6& pose) {
  Matrix6 K;
  RowRest rest;
  for (Eigen::Index i = 0; i < 6; ++i) {
    const double length = i < 3 ? 1.0 : row.stiffness.length;
    Vector6 step = Vector6::Zero();
    step[i] = kDifference / length;
    K.col(i) = (unbalanced(row, p_WH, R_WH, pose - step, rest) -
                unbalanced(row, p_WH, R_WH, pose + step, rest)) /
               (2.0 * kDifference);
  }
  return K;
}

}  // namespace

std::optional<RowRest> rest_on_row(const StringRow& row, const Vector3& p_WH,
                                   const Vector3& phi_WH) {
  const Matrix3 R_WH = rotation_of(phi_WH);
  Vector6 pose;
  pose << p_WH, phi_WH;
  // From above, so that every string is met from the side it is pressed from.
  pose[1] += 0.02;
  RowRest rest;
  Vector6 g = unbalanced(row, p_WH, R_WH, pose, rest);
  for (int i = 0; i < kMaxSteps; ++i) {
    const Matrix6 K = stiffness_at(row, p_WH, R_WH, pose);
    const double pull = row.stiffness.kt * (p_WH - rest.p_WG).norm();
    if (g.norm() <= kBalanced * (pull + 1.0)) {
      const Matrix6 symmetric = 0.5 * (K + K.transpose());
      const Eigen::LLT<Matrix6> stable(symmetric -
                                       kStable * row.stiffness.kt * Matrix6::Identity());
      if (stable.info() != Eigen::Success) return std::nullopt;
      static_cast<void>(unbalanced(row, p_WH, R_WH, pose, rest));
      if (slips(row, rest)) return std::nullopt;
      return rest;
    }
    Vector6 step = K.partialPivLu().solve(g);
    step.tail<3>() /= row.stiffness.length;
    double fraction = std::min(1.0, 2e-3 / step.head<3>().cwiseAbs().maxCoeff());
    for (int halving = 0; halving < 30; ++halving, fraction *= 0.5) {
      const Vector6 tried = pose + fraction * step;
      const Vector6 left = unbalanced(row, p_WH, R_WH, tried, rest);
      if (left.norm() < g.norm() || halving == 29) {
        pose = tried;
        g = left;
        break;
      }
    }
  }
  return std::nullopt;
}

}  // namespace hapticd::test
