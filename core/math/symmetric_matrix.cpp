// Cholesky factor, and Householder's reduction with the implicit QL method in plain loops. See
// symmetric_matrix.h. RT: yes.
#include "core/math/symmetric_matrix.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

/// Sweeps per eigenvalue; 2 are usual, the bound only guards against non-finite input.
constexpr int kMaxSweeps = 30;
/// Size beside the diagonal, relative to its neighbours there, that counts as zero. Smaller never
/// ends, larger leaves visible coupling.
constexpr double kDiagonalTolerance = 2e-16;

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
    std::array<double, kMaxDenseUnknowns> row;
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
    std::array<double, kMaxDenseUnknowns> row;
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

/// A symmetric matrix on its way to its spectrum: H = Z diag-and-beside Z', by rows of Z'.
struct Tridiagonal {
  std::array<double, kMaxDenseUnknowns> diagonal;
  std::array<double, kMaxDenseUnknowns> beside;  ///< of k and k + 1
  SquareMatrix transposed;                       ///< Z'
};

/// What makes the entries of column `k` of A beyond k + 1 zero: I - scale v v', v on rows from k
/// + 1.
struct Reflection {
  std::array<double, kMaxDenseUnknowns> v;
  double scale = 0.0;  ///< 0: they are zero
  double beside;       ///< what entry k + 1 becomes
};

Reflection reflection_of(const SquareMatrix& A, std::size_t k) noexcept {
  Reflection out;
  double beyond = 0.0;
  for (std::size_t i = k + 2; i < A.size; ++i) beyond += A(k, i) * A(k, i);
  out.beside = A(k, k + 1);
  if (!(beyond > 0.0)) return out;
  const double length = std::sqrt(A(k, k + 1) * A(k, k + 1) + beyond);
  out.beside = A(k, k + 1) > 0.0 ? -length : length;
  for (std::size_t i = k + 1; i < A.size; ++i) out.v[i] = A(k, i);
  out.v[k + 1] -= out.beside;
  out.scale = 2.0 / (out.v[k + 1] * out.v[k + 1] + beyond);
  return out;
}

/// A becomes P A P, of rows from `first`, P the reflection.
void reflect_both(const Reflection& P, std::size_t first, SquareMatrix& A) noexcept {
  const std::size_t n = A.size;
  std::array<double, kMaxDenseUnknowns> w{};
  for (std::size_t l = first; l < n; ++l) {
    const double factor = P.scale * P.v[l];
    for (std::size_t j = first; j < n; ++j) w[j] += factor * A(l, j);
  }
  double along = 0.0;
  for (std::size_t j = first; j < n; ++j) along += w[j] * P.v[j];
  for (std::size_t j = first; j < n; ++j) w[j] -= 0.5 * P.scale * along * P.v[j];
  for (std::size_t i = first; i < n; ++i) {
    for (std::size_t j = first; j < n; ++j) A(i, j) -= P.v[i] * w[j] + w[i] * P.v[j];
  }
}

/// Z becomes Z P.
void reflect_rows(const Reflection& P, std::size_t first, SquareMatrix& transposed) noexcept {
  const std::size_t n = transposed.size;
  std::array<double, kMaxDenseUnknowns> sum{};
  for (std::size_t l = first; l < n; ++l) {
    for (std::size_t i = 0; i < n; ++i) sum[i] += P.v[l] * transposed(l, i);
  }
  for (std::size_t l = first; l < n; ++l) {
    const double factor = P.scale * P.v[l];
    for (std::size_t i = 0; i < n; ++i) transposed(l, i) -= factor * sum[i];
  }
}

/// Householder's reduction of A, both of whose triangles are there, in place.
void reduce(SquareMatrix& A, Tridiagonal& out) noexcept {
  const std::size_t n = A.size;
  out.transposed.set_identity(n);
  for (std::size_t k = 0; k + 1 < n; ++k) {
    const Reflection P = reflection_of(A, k);
    out.beside[k] = P.beside;
    if (P.scale == 0.0) continue;
    reflect_both(P, k + 1, A);
    reflect_rows(P, k + 1, out.transposed);
  }
  for (std::size_t k = 0; k < n; ++k) out.diagonal[k] = A(k, k);
}

/// Rows i and i + 1 turned by an angle.
void turn_rows(double c, double s, std::size_t i, SquareMatrix& A) noexcept {
  double* __restrict a = A.entry[i].data();
  double* __restrict b = A.entry[i + 1].data();
  for (std::size_t k = 0; k < A.size; ++k) {
    const double before = a[k];
    a[k] = c * before - s * b[k];
    b[k] = s * before + c * b[k];
  }
}

/// One sweep of the implicit QL method over rows `first` to `last`.
void sweep_up(std::size_t first, std::size_t last, Tridiagonal& T) noexcept {
  auto& d = T.diagonal;
  auto& e = T.beside;
  const double half = (d[first + 1] - d[first]) / (2.0 * e[first]);
  const double root = std::sqrt(half * half + 1.0);
  double g = d[last] - d[first] + e[first] / (half < 0.0 ? half - root : half + root);
  double c = 1.0;
  double s = 1.0;
  double p = 0.0;
  for (std::size_t i = last; i-- > first;) {
    const double f = s * e[i];
    const double b = c * e[i];
    const double r = std::sqrt(f * f + g * g);
    if (i + 1 < last) e[i + 1] = r;
    if (!(r > 0.0)) {
      // The matrix has come apart here.
      d[i + 1] -= p;
      return;
    }
    const double inverse = 1.0 / r;
    s = f * inverse;
    c = g * inverse;
    g = d[i + 1] - p;
    const double change = (d[i] - g) * s + 2.0 * c * b;
    p = s * change;
    d[i + 1] = g + p;
    g = c * change - b;
    turn_rows(c, s, i, T.transposed);
  }
  d[first] -= p;
  e[first] = g;
}

/// The last row of those that hang together with row `first`.
std::size_t end_of_block(std::size_t first, const Tridiagonal& T) noexcept {
  std::size_t last = first;
  while (last + 1 < T.transposed.size) {
    const double size = std::abs(T.diagonal[last]) + std::abs(T.diagonal[last + 1]);
    if (std::abs(T.beside[last]) <= kDiagonalTolerance * size) break;
    ++last;
  }
  return last;
}

}  // namespace

void find_spectrum(const SquareMatrix& H, Spectrum& out) noexcept {
  SquareMatrix A;
  A.size = H.size;
  for (std::size_t i = 0; i < A.size; ++i) {
    for (std::size_t k = 0; k < A.size; ++k) A(i, k) = H(std::max(i, k), std::min(i, k));
  }
  Tridiagonal T;
  reduce(A, T);
  for (std::size_t first = 0; first < A.size; ++first) {
    for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
      const std::size_t last = end_of_block(first, T);
      if (last == first) break;
      sweep_up(first, last, T);
    }
  }
  out.vectors.size = A.size;
  for (std::size_t k = 0; k < A.size; ++k) {
    out.values[k] = T.diagonal[k];
    for (std::size_t i = 0; i < A.size; ++i) out.vectors(i, k) = T.transposed(k, i);
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
