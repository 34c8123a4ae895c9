// See coupling_axes.h. RT: yes.
#include "core/contact/coupling_axes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "core/math/elementary.h"

namespace hapticd {
namespace {

/// Below this angle the coefficients come from their series, rad, whose error is 1e-13 there.
constexpr double kSmallAngle = 0.1;

Matrix3 cross_matrix(const Vector3& v) noexcept {
  Matrix3 out;
  out << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return out;
}

/// J = 1 + [phi] / 2 + c [phi]^2; c, and its derivative by the angle over the angle.
struct InverseJacobian {
  double c;
  double slope;
};

InverseJacobian inverse_jacobian(double angle) noexcept {
  const double square = angle * angle;
  if (angle < kSmallAngle) {
    return {1.0 / 12.0 + square * (1.0 / 720.0 + square / 30240.0),
            1.0 / 360.0 + square * (1.0 / 7560.0 + square / 201600.0)};
  }
  const SinCos half = sin_cos(0.5 * angle);
  const double cot = half.cos / half.sin;
  const double c = (1.0 - 0.5 * angle * cot) / square;
  const double slope =
      (-2.0 / (square * angle) + 0.25 / (angle * half.sin * half.sin) + 0.5 * cot / square) / angle;
  return {c, slope};
}

Vector3 times_transpose(const InverseJacobian& J, const Vector3& phi, const Vector3& v) noexcept {
  const Vector3 once = phi.cross(v);
  return v - 0.5 * once + J.c * phi.cross(once);
}

/// The inverse of J': the left Jacobian of SO(3).
Vector3 times_left_jacobian(const Vector3& phi, const Vector3& v) noexcept {
  const double angle = phi.norm();
  const double square = angle * angle;
  double a = 0.5 - square * (1.0 / 24.0 - square * (1.0 / 720.0 - square / 40320.0));
  double b = 1.0 / 6.0 - square * (1.0 / 120.0 - square * (1.0 / 5040.0 - square / 362880.0));
  if (angle >= kSmallAngle) {
    const SinCos whole = sin_cos(angle);
    const SinCos half = sin_cos(0.5 * angle);
    a = 2.0 * half.sin * half.sin / square;
    b = (angle - whole.sin) / (square * angle);
  }
  const Vector3 once = phi.cross(v);
  return v + a * once + b * phi.cross(once);
}

/// Kr_W v or, with the stiffnesses inverted, Kr_W^-1 v.
Vector3 by_axes(const Quaternion& q_WH, const Vector3& about_G, const Vector3& v) noexcept {
  const Matrix3 R_WH = q_WH.toRotationMatrix();
  return R_WH * about_G.cwiseProduct(R_WH.transpose() * v);
}

/// The length with which kt length^2 is `kr`, to the bit where there is one.
double length_of(double kt, double kr) noexcept {
  const double length = std::sqrt(kr / kt);
  const auto bits = std::bit_cast<std::uint64_t>(length);
  const std::array<double, 3> near{length, std::bit_cast<double>(bits - 1),
                                   std::bit_cast<double>(bits + 1)};
  for (const double each : near) {
    if (kt * each * each == kr) return each;
  }
  return length;
}

}  // namespace

CouplingStiffness coupling_of_axes(const Vector3& along_W, const Vector3& about_G) noexcept {
  CouplingStiffness stiffness;
  stiffness.kt = along_W.maxCoeff();
  stiffness.length = length_of(stiffness.kt, about_G.maxCoeff());
  stiffness.shares = {along_W / stiffness.kt, about_G / about_G.maxCoeff()};
  stiffness.per_axis = along_W.minCoeff() < stiffness.kt || about_G.minCoeff() < about_G.maxCoeff();
  return stiffness;
}

CouplingStiffness normalised(const CouplingStiffness& stiffness) noexcept {
  if (!stiffness.per_axis) return stiffness;
  return coupling_of_axes(stiffness.along_W(), stiffness.about_G());
}

namespace axes {

double energy(const CouplingStiffness& stiffness, const Quaternion& q_WH,
              const PoseError& error_GH) noexcept {
  const auto& [dp, phi] = error_GH;
  return 0.5 * (dp.dot(stiffness.along_W().cwiseProduct(dp)) +
                phi.dot(by_axes(q_WH, stiffness.about_G(), phi)));
}

Wrench pull(const CouplingStiffness& stiffness, const Quaternion& q_WH,
            const PoseError& error_GH) noexcept {
  const auto& [dp, phi] = error_GH;
  return {
      stiffness.along_W().cwiseProduct(dp),
      times_transpose(inverse_jacobian(phi.norm()), phi, by_axes(q_WH, stiffness.about_G(), phi))};
}

PoseError stretch(const CouplingStiffness& stiffness, const Quaternion& q_WH,
                  const PoseError& error_GH, const Wrench& F_G_W) noexcept {
  const Vector3 t = times_left_jacobian(error_GH.dtheta, F_G_W.t);
  return {-F_G_W.f.cwiseQuotient(stiffness.along_W()),
          -by_axes(q_WH, stiffness.about_G().cwiseInverse(), t)};
}

}  // namespace axes

double stiffest_rotation(const CouplingStiffness& stiffness) noexcept {
  if (!stiffness.per_axis) return stiffness.kr();
  constexpr double kWorst = 0.25 * kPi * kPi;
  const double least = stiffness.shares.about_G.minCoeff();
  return stiffness.kr() * (least + kWorst * (1.0 - least));
}

// With w = Kr_W phi, and phi going by -J dtheta, the second derivative of phi along dtheta is minus
// that of J, so that the Hessian is J' Kr_W J and the symmetric part of M.
RotationUnits rotation_units(const CouplingStiffness& stiffness, const Quaternion& q_WH,
                             const PoseError& error_GH) noexcept {
  const Vector3& phi = error_GH.dtheta;
  const InverseJacobian coefficients = inverse_jacobian(phi.norm());
  const Matrix3 turn = cross_matrix(phi);
  const Matrix3 J = Matrix3::Identity() + 0.5 * turn + coefficients.c * turn * turn;
  const Vector3 w = by_axes(q_WH, stiffness.about_G(), phi);
  const Matrix3 inner = -0.5 * cross_matrix(w) -
                        coefficients.c * (cross_matrix(w) * turn + cross_matrix(w.cross(phi)));
  const Vector3 twice = turn * (turn * w);
  const Matrix3 M = J.transpose() * inner + coefficients.slope * phi * twice.transpose();
  const Matrix3 R_WH = q_WH.toRotationMatrix();
  const Vector3 root = stiffness.about_G().cwiseSqrt();
  RotationUnits units;
  for (Eigen::Index k = 0; k < 3; ++k) {
    // The right Jacobian is the left one of -phi.
    units.T.col(k) = times_left_jacobian(-phi, R_WH.col(k) / root[k]);
    units.inverse.row(k) = root[k] * (R_WH.col(k).transpose() * J);
  }
  units.beyond = units.T.transpose() * (0.5 * (M + M.transpose())) * units.T;
  return units;
}

void change_rotation(const Matrix3& T, std::size_t unknowns, ArrowMatrix& H) noexcept {
  for (std::size_t j = 0; j < 3; ++j) {
    const Vector3 below = T.transpose() * Vector3(H(3, j), H(4, j), H(5, j));
    for (std::size_t i = 0; i < 3; ++i) H(i + 3, j) = below[static_cast<Eigen::Index>(i)];
  }
  Matrix3 own;
  own << H(3, 3), H(4, 3), H(5, 3), H(4, 3), H(4, 4), H(5, 4), H(5, 3), H(5, 4), H(5, 5);
  own = T.transpose() * own * T;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      H(i + 3, j + 3) = own(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    }
  }
  for (std::size_t i = kToolDof; i < unknowns; ++i) {
    const Vector3 row = T.transpose() * Vector3(H(i, 3), H(i, 4), H(i, 5));
    for (std::size_t j = 0; j < 3; ++j) H(i, j + 3) = row[static_cast<Eigen::Index>(j)];
  }
}

}  // namespace hapticd
