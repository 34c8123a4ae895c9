// Square roots of small symmetric matrices, for changing to coordinates in which a metric is the
// identity. Plain loops: Eigen's general solvers allocate and their order of operations follows the
// CPU. RT: yes.
#pragma once

#include <array>
#include <cstddef>

#include "core/math/limits.h"
#include "core/math/realtime.h"

namespace hapticd {

/// A matrix of up to kMaxDenseUnknowns rows and as many columns; entries beyond `size` mean
/// nothing.
struct SquareMatrix {
  std::size_t size = 0;
  std::array<std::array<double, kMaxDenseUnknowns>, kMaxDenseUnknowns> entry;

  [[nodiscard]] double& operator()(std::size_t i, std::size_t j) noexcept { return entry[i][j]; }
  [[nodiscard]] double operator()(std::size_t i, std::size_t j) const noexcept {
    return entry[i][j];
  }
  /// Becomes the identity of `rows` rows.
  void set_identity(std::size_t rows) noexcept {
    size = rows;
    for (std::size_t i = 0; i < rows; ++i) {
      for (std::size_t j = 0; j < rows; ++j) entry[i][j] = i == j ? 1.0 : 0.0;
    }
  }
};

/// Eigenvalues in no order, and the orthonormal eigenvectors as columns: H = vectors diag(values)
/// vectors'.
struct Spectrum {
  std::array<double, kMaxDenseUnknowns> values;
  SquareMatrix vectors;
};

/// Spectrum of symmetric `H` (lower triangle read, finite) by Householder's reduction and the
/// implicit QL method (Golub and Van Loan, "Matrix Computations", 8.3); error <= 1e-14 |H|. About
/// 0.8 us for 6 rows, growing with their cube.
HD_REALTIME void find_spectrum(const SquareMatrix& H, Spectrum& out) noexcept;

/// B with B' H B = 1 for symmetric `H`. Where H is not safely positive definite (a Cholesky pivot
/// below `least`) its eigenvalues are replaced by their magnitudes, at least `least` > 0. About 60
/// ns for 6 rows, or 2 us by the second way.
HD_REALTIME void inverse_square_root(const SquareMatrix& H, double least, SquareMatrix& B) noexcept;

}  // namespace hapticd
