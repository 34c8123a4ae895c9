// Truth: the defining identities, evaluated in long double, and matrices built from known spectra.
#include "core/math/symmetric_matrix.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

using LongMatrix = Eigen::Matrix<long double, 6, 6>;

/// Orthogonal matrix: product of random plane rotations.
LongMatrix random_orthogonal(SplitMix64& random) {
  LongMatrix Q = LongMatrix::Identity();
  for (Eigen::Index p = 0; p < 6; ++p) {
    for (Eigen::Index q = p + 1; q < 6; ++q) {
      const long double angle = random.uniform(-3.2, 3.2);
      LongMatrix R = LongMatrix::Identity();
      R(p, p) = R(q, q) = std::cos(angle);
      R(p, q) = -std::sin(angle);
      R(q, p) = std::sin(angle);
      Q = Q * R;
    }
  }
  return Q;
}

Matrix6 with_spectrum(SplitMix64& random, const Vector6& values) {
  const LongMatrix Q = random_orthogonal(random);
  const LongMatrix H = Q * values.cast<long double>().asDiagonal() * Q.transpose();
  return H.cast<double>();
}

/// B' H B, which should be the identity.
LongMatrix in_basis(const Matrix6& B, const Matrix6& H) {
  return B.cast<long double>().transpose() * H.cast<long double>() * B.cast<long double>();
}

}  // namespace

TEST_CASE("the basis of a positive definite matrix turns it into the identity") {
  SplitMix64 random(3);
  for (std::int64_t i = 0; i < scaled(100'000); ++i) {
    Vector6 values;
    for (double& value : values) value = std::pow(10.0, random.uniform(-1.0, 3.0));
    const Matrix6 H = with_spectrum(random, values);
    const Matrix6 B = inverse_square_root(H, 1e-3);
    REQUIRE((in_basis(B, H) - LongMatrix::Identity()).cwiseAbs().maxCoeff() < 1e-10L);
  }
}

TEST_CASE(
    "the spectrum of a matrix with known eigenvalues is found, double and zero ones included") {
  SplitMix64 random(4);
  for (std::int64_t i = 0; i < scaled(100'000); ++i) {
    Vector6 values;
    for (double& value : values) value = random.uniform(-2.0, 2.0);
    if (random.chance(0.3)) values[1] = values[0];
    if (random.chance(0.3)) values[5] = 0.0;
    const Matrix6 H = with_spectrum(random, values);
    Spectrum6 found = spectrum(H);
    const LongMatrix V = found.vectors.cast<long double>();
    REQUIRE((V.transpose() * V - LongMatrix::Identity()).cwiseAbs().maxCoeff() < 1e-13L);
    const LongMatrix rebuilt = V * found.values.cast<long double>().asDiagonal() * V.transpose();
    REQUIRE((rebuilt - H.cast<long double>()).cwiseAbs().maxCoeff() < 1e-13L);
    std::sort(values.begin(), values.end());
    std::sort(found.values.begin(), found.values.end());
    REQUIRE((values - found.values).cwiseAbs().maxCoeff() < 1e-13);
  }
}

TEST_CASE("an indefinite matrix gets the basis of its documented positive replacement") {
  SplitMix64 random(5);
  constexpr double kLeast = 0.02;
  for (std::int64_t i = 0; i < scaled(100'000); ++i) {
    Vector6 values;
    for (double& value : values) value = random.uniform(-3.0, 1.0);
    values[0] = random.uniform(-3.0, -1.0);
    const LongMatrix Q = random_orthogonal(random);
    const LongMatrix H = Q * values.cast<long double>().asDiagonal() * Q.transpose();
    Vector6 replaced;
    for (Eigen::Index k = 0; k < 6; ++k) {
      replaced[k] = std::max(values[k] < 0.0 ? -0.5 * values[k] : values[k], kLeast);
    }
    const LongMatrix positive = Q * replaced.cast<long double>().asDiagonal() * Q.transpose();
    const Matrix6 B = inverse_square_root(H.cast<double>(), kLeast);
    REQUIRE((in_basis(B, positive.cast<double>()) - LongMatrix::Identity()).cwiseAbs().maxCoeff() <
            1e-9L);
  }
}

}  // namespace hapticd::test
