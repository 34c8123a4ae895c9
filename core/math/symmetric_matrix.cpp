// Cholesky factor and Jacobi rotations in plain loops. See symmetric_matrix.h. RT: yes.
#include "core/math/symmetric_matrix.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

constexpr Eigen::Index kSize = 6;
/// Sweeps over all off-diagonal elements; 4 to 6 suffice for 6 x 6, the bound only guards against
/// non-finite input.
constexpr int kMaxSweeps = 12;
/// Off-diagonal size, relative to the matrix, that counts as zero. Smaller never ends, larger
/// leaves visible coupling.
constexpr double kDiagonalTolerance = 1e-15;

/// Share of its magnitude that a negative eigenvalue counts. 1 doubles the distance from a ridge
/// with each step, 0.5 triples it.
constexpr double kRidgeShare = 0.5;

/// H = L L' with all pivots >= least; false when there is no such factor.
bool cholesky(const Matrix6& H, double least, Matrix6& L) noexcept {
  for (Eigen::Index j = 0; j < kSize; ++j) {
    double pivot = H(j, j);
    for (Eigen::Index k = 0; k < j; ++k) pivot -= L(j, k) * L(j, k);
    if (!(pivot >= least)) return false;
    L(j, j) = std::sqrt(pivot);
    const double inverse = 1.0 / L(j, j);
    for (Eigen::Index i = j + 1; i < kSize; ++i) {
      double sum = H(i, j);
      for (Eigen::Index k = 0; k < j; ++k) sum -= L(i, k) * L(j, k);
      L(i, j) = sum * inverse;
    }
  }
  return true;
}

/// The upper triangular inverse of L', column by column.
Matrix6 inverse_transposed(const Matrix6& L) noexcept {
  Matrix6 B = Matrix6::Zero();
  for (Eigen::Index j = 0; j < kSize; ++j) {
    // Column j of inverse(L) is row j of B.
    B(j, j) = 1.0 / L(j, j);
    for (Eigen::Index i = j + 1; i < kSize; ++i) {
      double sum = 0.0;
      for (Eigen::Index k = j; k < i; ++k) sum -= L(i, k) * B(j, k);
      B(j, i) = sum / L(i, i);
    }
  }
  return B;
}

double off_diagonal(const Matrix6& A) noexcept {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < kSize; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) sum += A(i, j) * A(i, j);
  }
  return std::sqrt(sum);
}

/// One Jacobi rotation in the plane (p, q) that makes A(p, q) zero, accumulated in `vectors`.
void rotate(Matrix6& A, Matrix6& vectors, Eigen::Index p, Eigen::Index q) noexcept {
  if (A(p, q) == 0.0) return;
  const double theta = 0.5 * (A(q, q) - A(p, p)) / A(p, q);
  const double root = std::abs(theta) + std::sqrt(theta * theta + 1.0);
  const double t = theta < 0.0 ? -1.0 / root : 1.0 / root;
  const double c = 1.0 / std::sqrt(t * t + 1.0);
  const double s = t * c;
  const auto turn = [c, s](double& a, double& b) {
    const double before = a;
    a = c * before - s * b;
    b = s * before + c * b;
  };
  for (Eigen::Index k = 0; k < kSize; ++k) turn(A(k, p), A(k, q));
  for (Eigen::Index k = 0; k < kSize; ++k) turn(A(p, k), A(q, k));
  for (Eigen::Index k = 0; k < kSize; ++k) turn(vectors(k, p), vectors(k, q));
}

}  // namespace

Spectrum6 spectrum(const Matrix6& H) noexcept {
  Matrix6 A = H;
  for (Eigen::Index i = 0; i < kSize; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) A(j, i) = A(i, j);
  }
  Spectrum6 out;
  out.vectors.setIdentity();
  const double tolerance = kDiagonalTolerance * (off_diagonal(A) + A.diagonal().cwiseAbs().sum());
  for (int sweep = 0; sweep < kMaxSweeps && off_diagonal(A) > tolerance; ++sweep) {
    for (Eigen::Index p = 0; p < kSize; ++p) {
      for (Eigen::Index q = p + 1; q < kSize; ++q) rotate(A, out.vectors, p, q);
    }
  }
  out.values = A.diagonal();
  return out;
}

Matrix6 inverse_square_root(const Matrix6& H, double least) noexcept {
  Matrix6 L;
  if (cholesky(H, least, L)) return inverse_transposed(L);
  Spectrum6 s = spectrum(H);
  for (Eigen::Index k = 0; k < kSize; ++k) {
    const double value = s.values[k];
    const double size = value < 0.0 ? -kRidgeShare * value : value;
    s.vectors.col(k) /= std::sqrt(std::max(size, least));
  }
  return s.vectors;
}

}  // namespace hapticd
