// Truth: the defining identities, evaluated in long double, and matrices built from known spectra.
#include "core/math/symmetric_matrix.h"

#include <doctest/doctest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using LongVector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

/// Mostly a rigid tool's six rows, else any size there may be.
Eigen::Index random_size(SplitMix64& random) {
  return random.chance(0.5) ? 6 : 1 + static_cast<Eigen::Index>(random.below(kMaxDenseUnknowns));
}

/// Orthogonal matrix: product of random plane rotations.
LongMatrix random_orthogonal(SplitMix64& random, Eigen::Index size) {
  LongMatrix Q = LongMatrix::Identity(size, size);
  for (Eigen::Index p = 0; p < size; ++p) {
    for (Eigen::Index q = p + 1; q < size; ++q) {
      const long double angle = random.uniform(-3.2, 3.2);
      const LongVector column_p = Q.col(p);
      Q.col(p) = std::cos(angle) * column_p + std::sin(angle) * Q.col(q);
      Q.col(q) = std::cos(angle) * LongVector(Q.col(q)) - std::sin(angle) * column_p;
    }
  }
  return Q;
}

LongMatrix with_spectrum(const LongMatrix& Q, const LongVector& values) {
  return Q * values.asDiagonal() * Q.transpose();
}

SquareMatrix rounded(const LongMatrix& H) {
  SquareMatrix out;
  out.size = static_cast<std::size_t>(H.rows());
  for (std::size_t i = 0; i < out.size; ++i) {
    for (std::size_t j = 0; j < out.size; ++j) {
      out(i, j) =
          static_cast<double>(H(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
    }
  }
  return out;
}

LongMatrix exact(const SquareMatrix& H) {
  const auto size = static_cast<Eigen::Index>(H.size);
  LongMatrix out(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index j = 0; j < size; ++j) {
      out(i, j) = H(static_cast<std::size_t>(i), static_cast<std::size_t>(j));
    }
  }
  return out;
}

/// Largest entry of B' H B - 1.
long double distance_from_identity(const SquareMatrix& B, const LongMatrix& H) {
  const LongMatrix b = exact(B);
  return (b.transpose() * H * b - LongMatrix::Identity(b.rows(), b.rows())).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("the basis of a positive definite matrix turns it into the identity") {
  SplitMix64 random(3);
  for (std::int64_t i = 0; i < scaled(50'000); ++i) {
    const Eigen::Index size = random_size(random);
    LongVector values(size);
    for (long double& value : values) value = std::pow(10.0, random.uniform(-1.0, 3.0));
    const SquareMatrix H = rounded(with_spectrum(random_orthogonal(random, size), values));
    SquareMatrix B;
    inverse_square_root(H, 1e-3, B);
    REQUIRE(B.size == H.size);
    REQUIRE(distance_from_identity(B, exact(H)) < 1e-9L);
  }
}

TEST_CASE(
    "the spectrum of a matrix with known eigenvalues is found, double and zero ones included") {
  SplitMix64 random(4);
  for (std::int64_t i = 0; i < scaled(50'000); ++i) {
    const Eigen::Index size = random_size(random);
    LongVector values(size);
    for (long double& value : values) value = random.uniform(-2.0, 2.0);
    if (random.chance(0.3)) values[size / 2] = values[0];
    if (random.chance(0.3)) values[size - 1] = 0.0;
    LongMatrix Q = random_orthogonal(random, size);
    // Rows that have nothing beside the diagonal, among others or alone.
    const double alone = random.chance(0.5) ? 0.0 : random.uniform();
    for (Eigen::Index k = 0; k < size; ++k) {
      if (!random.chance(alone)) continue;
      Q = LongMatrix::Identity(size, size);
      Q.bottomRightCorner(size - k, size - k) = random_orthogonal(random, size - k);
      break;
    }
    const SquareMatrix H = rounded(with_spectrum(Q, values));
    Spectrum found;
    find_spectrum(H, found);
    const LongMatrix V = exact(found.vectors);
    REQUIRE((V.transpose() * V - LongMatrix::Identity(size, size)).cwiseAbs().maxCoeff() < 1e-13L);
    LongVector found_values(size);
    for (Eigen::Index k = 0; k < size; ++k) {
      found_values[k] = found.values[static_cast<std::size_t>(k)];
    }
    REQUIRE((with_spectrum(V, found_values) - exact(H)).cwiseAbs().maxCoeff() < 1e-12L);
    std::sort(values.begin(), values.end());
    std::sort(found_values.begin(), found_values.end());
    REQUIRE((values - found_values).cwiseAbs().maxCoeff() < 1e-12L);
  }
}

TEST_CASE("an indefinite matrix gets the basis of its documented positive replacement") {
  SplitMix64 random(5);
  constexpr double kMin = 0.02;
  for (std::int64_t i = 0; i < scaled(50'000); ++i) {
    const Eigen::Index size = random_size(random);
    LongVector values(size);
    for (long double& value : values) value = random.uniform(-3.0, 1.0);
    values[0] = random.uniform(-3.0, -1.0);
    const LongMatrix Q = random_orthogonal(random, size);
    LongVector replaced(size);
    for (Eigen::Index k = 0; k < size; ++k) {
      const long double magnitude = values[k] < 0 ? -values[k] / 2 : values[k];
      replaced[k] = std::max(magnitude, static_cast<long double>(kMin));
    }
    SquareMatrix B;
    inverse_square_root(rounded(with_spectrum(Q, values)), kMin, B);
    REQUIRE(distance_from_identity(B, with_spectrum(Q, replaced)) < 1e-8L);
  }
}

}  // namespace hapticd::test
