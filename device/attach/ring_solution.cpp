// See ring_solution.h.
#include "device/attach/ring_solution.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace hapticd {
namespace {

using RingMatrix = Eigen::Matrix<double, kRingUnknowns, kRingUnknowns>;

/// Sums of least squares.
struct Sums {
  RingMatrix N = RingMatrix::Zero();
  RingVector g = RingVector::Zero();
  double square = 0.0;
  std::size_t rows = 0;
};

Sums sums_of(std::span<const RingEquations* const> rings, const RingGiven& given) {
  Sums sums;
  for (const RingEquations* const ring : rings) {
    for (const RingEquation& equation : ring->all) {
      RingVector row = equation.row;
      double force = equation.force;
      for (int i = 0; i < kRingUnknowns; ++i) {
        if (!given[static_cast<std::size_t>(i)]) continue;
        force -= row[i] * *given[static_cast<std::size_t>(i)];
        row[i] = 0.0;
      }
      sums.N += row * row.transpose();
      sums.g += row * force;
      sums.square += equation.force * equation.force;
      ++sums.rows;
    }
  }
  for (int i = 0; i < kRingUnknowns; ++i) {
    const std::optional<double>& value = given[static_cast<std::size_t>(i)];
    if (!value) continue;
    sums.N(i, i) = 1.0;
    sums.g[i] = *value;
  }
  return sums;
}

/// The inverse, scaled; none: singular.
std::optional<RingMatrix> inverse_of(const RingMatrix& N) {
  const RingVector scale = N.diagonal().cwiseMax(0.0).cwiseSqrt();
  if (!(scale.minCoeff() > 0.0)) return std::nullopt;
  const RingVector inverse = scale.cwiseInverse();
  const Eigen::FullPivLU<RingMatrix> factor(inverse.asDiagonal() * N * inverse.asDiagonal());
  if (!factor.isInvertible()) return std::nullopt;
  return inverse.asDiagonal() * factor.inverse() * inverse.asDiagonal();
}

/// What is left unexplained.
struct Left {
  RingMatrix spread = RingMatrix::Zero();  ///< of the gradient
  double square = 0.0;
  double stretches = 0.0;  ///< that share no samples, about
};

void add_left(const RingEquations& ring, const RingVector& p, Left& left) {
  std::vector<RingVector> parts;
  parts.reserve(ring.all.size());
  for (const RingEquation& equation : ring.all) {
    const double miss = equation.force - equation.row.dot(p);
    left.square += miss * miss;
    parts.emplace_back(equation.row * miss);
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    left.spread += parts[i] * parts[i].transpose();
    for (std::size_t lag = 1; lag <= std::min(ring.overlap, i); ++lag) {
      const double weight = 1.0 - static_cast<double>(lag) / static_cast<double>(ring.overlap + 1);
      const RingMatrix product = parts[i] * parts[i - lag].transpose();
      left.spread += weight * (product + product.transpose());
    }
  }
  left.stretches +=
      static_cast<double>(parts.size()) / std::max(1.0, 0.5 * static_cast<double>(ring.overlap));
}

}  // namespace

std::optional<RingSolution> solve(std::span<const RingEquations* const> rings,
                                  const RingGiven& given) {
  const auto found = std::count(given.begin(), given.end(), std::nullopt);
  const Sums sums = sums_of(rings, given);
  if (sums.rows <= static_cast<std::size_t>(found)) return std::nullopt;
  std::optional<RingMatrix> inverse = inverse_of(sums.N);
  if (!inverse) return std::nullopt;
  RingSolution solution;
  solution.p = *inverse * sums.g;
  for (int i = 0; i < kRingUnknowns; ++i) {
    if (!given[static_cast<std::size_t>(i)]) continue;
    inverse->row(i).setZero();
    inverse->col(i).setZero();
  }
  Left left;
  for (const RingEquations* const ring : rings) add_left(*ring, solution.p, left);
  const auto unknowns = static_cast<double>(found);
  const double stretches = std::max(left.stretches, unknowns + 2.0);
  const RingMatrix spread = *inverse * left.spread * *inverse;
  solution.error =
      (spread.diagonal().cwiseMax(0.0) * (stretches / (stretches - unknowns))).cwiseSqrt();
  solution.residual = std::sqrt(left.square / sums.square);
  if (!solution.p.allFinite() || !solution.error.allFinite()) return std::nullopt;
  return solution;
}

}  // namespace hapticd
