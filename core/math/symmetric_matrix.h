// Square roots of symmetric 6 x 6 matrices, for changing to coordinates in which a metric is the
// identity. Plain loops of fixed length: Eigen's general solvers allocate and their order of
// operations follows the CPU. RT: yes.
#pragma once

#include "core/math/realtime.h"
#include "core/math/vector.h"

namespace hapticd {

/// Eigenvalues in no order, and the orthonormal eigenvectors as columns: H = vectors diag(values)
/// vectors'.
struct Spectrum6 {
  Vector6 values;
  Matrix6 vectors;
};

/// Spectrum of symmetric `H` (lower triangle read, finite) by cyclic Jacobi rotations (Golub and
/// Van Loan, "Matrix Computations", 8.5); off-diagonal <= 1e-15 |H| on return. About 2 us.
[[nodiscard]] HD_REALTIME Spectrum6 spectrum(const Matrix6& H) noexcept;

/// B with B' H B = 1 for symmetric `H`. Where H is not safely positive definite (a Cholesky pivot
/// below `least`) its eigenvalues are replaced by their magnitudes, at least `least` > 0. About 60
/// ns, or 2 us by the second way.
[[nodiscard]] HD_REALTIME Matrix6 inverse_square_root(const Matrix6& H, double least) noexcept;

}  // namespace hapticd
