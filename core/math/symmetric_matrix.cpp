// Cholesky factor and Jacobi rotations in plain loops. See symmetric_matrix.h. RT: yes.
#include "core/math/symmetric_matrix.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

/// Sweeps over all off-diagonal elements; 4 to 6 suffice, the bound only guards against non-finite
/// input.
constexpr int kMaxSweeps = 12;
/// Off-diagonal size, relative to the matrix, that counts as zero. Smaller never ends, larger
/// leaves visible coupling.
constexpr double kDiagonalTolerance = 1e-15;

/// Share of its magnitude that a negative eigenvalue counts. 1 doubles the distance from a ridge
/// with each step, 0.5 triples it.
constexpr double kRidgeShare = 0.5;

/// N, or the size of the matrix where N = 0: the usual sizes are known to the compiler.
template <std::size_t N>
std::size_t size_of(const SquareMatrix& A) noexcept {
  return N > 0 ? N : A.size;
}

/// The upper triangle U of H = U' U with all pivots >= least; false when there is no such factor.
/// Whole rows are worked on, because that is faster; below the diagonal they mean nothing.
template <std::size_t N>
bool cholesky(const SquareMatrix& H, double least, SquareMatrix& U) noexcept {
  const std::size_t n = size_of<N>(H);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < n; ++k) U(i, k) = H(std::max(i, k), std::min(i, k));
  }
  for (std::size_t j = 0; j < n; ++j) {
    if (!(U(j, j) >= least)) return false;
    const double inverse = 1.0 / std::sqrt(U(j, j));
    // A copy, so that the compiler knows that the rows are different ones.
    std::array<double, kMaxQpUnknowns> row;
    for (std::size_t k = 0; k < n; ++k) row[k] = U(j, k) * inverse;
    for (std::size_t k = 0; k < n; ++k) U(j, k) = row[k];
    for (std::size_t i = j + 1; i < n; ++i) {
      const double factor = row[i];
      for (std::size_t k = 0; k < n; ++k) U(i, k) -= factor * row[k];
    }
  }
  return true;
}

/// B = inverse(U), row by row from the last.
template <std::size_t N>
void invert_upper(const SquareMatrix& U, SquareMatrix& B) noexcept {
  const std::size_t n = size_of<N>(B);
  for (std::size_t i = n; i-- > 0;) {
    std::array<double, kMaxQpUnknowns> row;
    for (std::size_t k = 0; k < n; ++k) row[k] = k == i ? 1.0 : 0.0;
    for (std::size_t j = i + 1; j < n; ++j) {
      const double factor = U(i, j);
      for (std::size_t k = 0; k < n; ++k) row[k] -= factor * B(j, k);
    }
    const double inverse = 1.0 / U(i, i);
    for (std::size_t k = 0; k < n; ++k) B(i, k) = row[k] * inverse;
  }
}

/// B from the Cholesky factor; false when there is none.
template <std::size_t N>
bool invert_root(const SquareMatrix& H, double least, SquareMatrix& B) noexcept {
  SquareMatrix U;
  if (!cholesky<N>(H, least, U)) return false;
  invert_upper<N>(U, B);
  return true;
}

double off_diagonal(const SquareMatrix& A) noexcept {
  double sum = 0.0;
  for (std::size_t i = 0; i < A.size; ++i) {
    for (std::size_t j = 0; j < i; ++j) sum += A(i, j) * A(i, j);
  }
  return std::sqrt(sum);
}

/// Two numbers turned by an angle.
struct Turn {
  double c, s;
  void operator()(double& a, double& b) const noexcept {
    const double before = a;
    a = c * before - s * b;
    b = s * before + c * b;
  }
  /// Rows p != q of `A`, n long. Copies, so that the compiler knows that they are different ones.
  void rows(SquareMatrix& A, std::size_t p, std::size_t q, std::size_t n) const noexcept {
    std::array<double, kMaxQpUnknowns> row_p;
    std::array<double, kMaxQpUnknowns> row_q;
    for (std::size_t k = 0; k < n; ++k) {
      row_p[k] = c * A(p, k) - s * A(q, k);
      row_q[k] = s * A(p, k) + c * A(q, k);
    }
    for (std::size_t k = 0; k < n; ++k) A(p, k) = row_p[k];
    for (std::size_t k = 0; k < n; ++k) A(q, k) = row_q[k];
  }
};

/// One Jacobi rotation in the plane (p, q) that makes A(p, q) zero, accumulated in the rows of
/// `transposed`. A is symmetric, so that its columns become what its rows do.
void rotate(SquareMatrix& A, SquareMatrix& transposed, std::size_t p, std::size_t q) noexcept {
  const double theta = 0.5 * (A(q, q) - A(p, p)) / A(p, q);
  const double root = std::abs(theta) + std::sqrt(theta * theta + 1.0);
  const double t = theta < 0.0 ? -1.0 / root : 1.0 / root;
  const double c = 1.0 / std::sqrt(t * t + 1.0);
  const Turn turn{c, t * c};
  turn(A(p, p), A(p, q));
  turn(A(q, p), A(q, q));
  turn.rows(A, p, q, A.size);
  for (std::size_t k = 0; k < A.size; ++k) {
    if (k == p || k == q) continue;
    A(k, p) = A(p, k);
    A(k, q) = A(q, k);
  }
  turn.rows(transposed, p, q, A.size);
}

}  // namespace

void find_spectrum(const SquareMatrix& H, Spectrum& out) noexcept {
  SquareMatrix A = H;
  double size = 0.0;
  for (std::size_t i = 0; i < A.size; ++i) {
    for (std::size_t j = 0; j < i; ++j) A(j, i) = A(i, j);
    size += std::abs(A(i, i));
  }
  SquareMatrix transposed;
  transposed.set_identity(A.size);
  const double tolerance = kDiagonalTolerance * (off_diagonal(A) + size);
  // As small are all of them together within the tolerance.
  const double negligible = tolerance / static_cast<double>(A.size);
  for (int sweep = 0; sweep < kMaxSweeps && off_diagonal(A) > tolerance; ++sweep) {
    for (std::size_t p = 0; p < A.size; ++p) {
      for (std::size_t q = p + 1; q < A.size; ++q) {
        if (std::abs(A(p, q)) > negligible) rotate(A, transposed, p, q);
      }
    }
  }
  out.vectors.size = A.size;
  for (std::size_t k = 0; k < A.size; ++k) {
    out.values[k] = A(k, k);
    for (std::size_t i = 0; i < A.size; ++i) out.vectors(i, k) = transposed(k, i);
  }
}

void inverse_square_root(const SquareMatrix& H, double least, SquareMatrix& B) noexcept {
  B.size = H.size;
  const bool definite = H.size == 6   ? invert_root<6>(H, least, B)
                        : H.size == 8 ? invert_root<8>(H, least, B)
                                      : invert_root<0>(H, least, B);
  if (definite) return;
  Spectrum s;
  find_spectrum(H, s);
  for (std::size_t k = 0; k < H.size; ++k) {
    const double value = s.values[k];
    const double size = value < 0.0 ? -kRidgeShare * value : value;
    const double root = std::sqrt(std::max(size, least));
    for (std::size_t i = 0; i < H.size; ++i) B(i, k) = s.vectors(i, k) / root;
  }
}

}  // namespace hapticd
