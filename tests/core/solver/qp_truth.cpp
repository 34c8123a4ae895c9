// Straightforward sums and Gaussian elimination; slow and obvious.
#include "tests/core/solver/qp_truth.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace hapticd::test {
namespace {

constexpr long double kInfinity = std::numeric_limits<long double>::infinity();

std::size_t size_of(int count) { return static_cast<std::size_t>(count); }

long double root_weight(const QpProblem& problem, std::size_t k) {
  return std::sqrt(static_cast<long double>(problem.weight[k]));
}

LongVector scaled_row(const QpProblem& problem, std::size_t i) {
  LongVector c{};
  for (std::size_t k = 0; k < size_of(problem.unknowns); ++k) {
    c[k] = problem.row[k][i] / root_weight(problem, k);
  }
  return c;
}

long double dot(const LongVector& a, const LongVector& b) {
  long double sum = 0.0L;
  for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

long double length(const LongVector& a) { return std::sqrt(dot(a, a)); }

LongVector scaled_point(const QpProblem& problem, const LongVector& x) {
  LongVector z{};
  for (std::size_t k = 0; k < size_of(problem.unknowns); ++k) z[k] = root_weight(problem, k) * x[k];
  return z;
}

LongVector widen(const std::array<double, kMaxQpUnknowns>& x, int unknowns) {
  LongVector wide{};
  for (std::size_t k = 0; k < size_of(unknowns); ++k) wide[k] = x[k];
  return wide;
}

bool active_rows_are_well_formed(const QpProblem& problem, const QpSolution& solution) {
  if (solution.active_count < 0 || solution.active_count > problem.unknowns) return false;
  for (std::size_t j = 0; j < size_of(solution.active_count); ++j) {
    if (solution.active[j] < 0 || solution.active[j] >= problem.rows) return false;
    for (std::size_t i = 0; i < j; ++i) {
      if (solution.active[i] == solution.active[j]) return false;
    }
  }
  return true;
}

/// Solves the square system in place by elimination with pivoting; false when nearly singular.
bool solve_linear(std::vector<std::vector<long double>>& a, std::vector<long double>& b) {
  const std::size_t n = b.size();
  for (std::size_t column = 0; column < n; ++column) {
    std::size_t pivot = column;
    for (std::size_t i = column + 1; i < n; ++i) {
      if (std::abs(a[i][column]) > std::abs(a[pivot][column])) pivot = i;
    }
    if (std::abs(a[pivot][column]) < 1e-13L) return false;
    std::swap(a[pivot], a[column]);
    std::swap(b[pivot], b[column]);
    for (std::size_t i = column + 1; i < n; ++i) {
      const long double factor = a[i][column] / a[column][column];
      for (std::size_t k = column; k < n; ++k) a[i][k] -= factor * a[column][k];
      b[i] -= factor * b[column];
    }
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) b[i] -= a[i][k] * b[k];
    b[i] /= a[i][i];
  }
  return true;
}

/// Rows of unit length in the scaled space.
struct Polyhedron {
  std::vector<LongVector> normal;
  std::vector<long double> offset;
  LongVector target{};

  [[nodiscard]] bool contains(const LongVector& z) const {
    for (std::size_t i = 0; i < normal.size(); ++i) {
      if (dot(normal[i], z) < offset[i] - 1e-13L * (1.0L + length(z))) return false;
    }
    return true;
  }

  /// Projection of the target onto the planes of `rows`; false when these depend on each other.
  [[nodiscard]] bool project(const std::vector<std::size_t>& rows, LongVector& z) const {
    std::vector<std::vector<long double>> gram(rows.size(), std::vector<long double>(rows.size()));
    std::vector<long double> u(rows.size());
    for (std::size_t a = 0; a < rows.size(); ++a) {
      for (std::size_t b = 0; b < rows.size(); ++b)
        gram[a][b] = dot(normal[rows[a]], normal[rows[b]]);
      u[a] = offset[rows[a]] - dot(normal[rows[a]], target);
    }
    if (!solve_linear(gram, u)) return false;
    z = target;
    for (std::size_t a = 0; a < rows.size(); ++a) {
      for (std::size_t k = 0; k < z.size(); ++k) z[k] += u[a] * normal[rows[a]][k];
    }
    return true;
  }
};

long double distance_squared(const LongVector& a, const LongVector& b) {
  long double sum = 0.0L;
  for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return sum;
}

}  // namespace

long double KktViolations::worst() const {
  if (!well_formed) return kInfinity;
  const long double largest = std::max({stationarity, primal, dual, complementarity});
  return std::isnan(stationarity + primal + dual + complementarity) ? kInfinity : largest;
}

KktViolations kkt_violations(const QpProblem& problem, const QpSolution& solution) {
  KktViolations found;
  found.well_formed = active_rows_are_well_formed(problem, solution);
  if (!found.well_formed) return found;
  const LongVector z = scaled_point(problem, widen(solution.x, problem.unknowns));
  const LongVector target = scaled_point(problem, widen(problem.target, problem.unknowns));
  const long double size = std::max({length(z), length(target), 1e-300L});

  LongVector imbalance{};
  for (std::size_t k = 0; k < z.size(); ++k) imbalance[k] = z[k] - target[k];
  long double sum = 0.0L;
  for (std::size_t j = 0; j < size_of(solution.active_count); ++j) {
    const auto i = static_cast<std::size_t>(solution.active[j]);
    const LongVector c = scaled_row(problem, i);
    const long double multiplier = solution.multiplier[j] * length(c);
    const long double slack = (dot(c, z) - problem.bound[i]) / length(c);
    for (std::size_t k = 0; k < z.size(); ++k) imbalance[k] -= solution.multiplier[j] * c[k];
    sum += std::abs(multiplier);
    found.dual = std::max(found.dual, -multiplier / size);
    found.complementarity = std::max(found.complementarity, std::min(multiplier, slack) / size);
  }
  found.stationarity = length(imbalance) / std::max(size, sum);

  for (std::size_t i = 0; i < size_of(problem.rows); ++i) {
    const LongVector c = scaled_row(problem, i);
    const long double lacking = problem.bound[i] - dot(c, z);
    if (lacking <= 0.0L) continue;
    const long double relative =
        lacking / std::max(length(c) * size, std::abs(static_cast<long double>(problem.bound[i])));
    found.primal = std::max(found.primal, relative);
  }
  return found;
}

ExhaustiveOptimum exhaustive_optimum(const QpProblem& problem) {
  Polyhedron polyhedron;
  polyhedron.target = scaled_point(problem, widen(problem.target, problem.unknowns));
  for (std::size_t i = 0; i < size_of(problem.rows); ++i) {
    LongVector c = scaled_row(problem, i);
    const long double size = length(c);
    if (size == 0.0L) {
      if (problem.bound[i] > 0.0) return {};
      continue;
    }
    for (long double& entry : c) entry /= size;
    polyhedron.normal.push_back(c);
    polyhedron.offset.push_back(problem.bound[i] / size);
  }
  long double best = kInfinity;
  LongVector best_z{};
  // Bit i of a set: row i is held with equality.
  for (std::uint64_t set = 0; set < std::uint64_t{1} << polyhedron.normal.size(); ++set) {
    if (std::popcount(set) > problem.unknowns) continue;
    std::vector<std::size_t> rows;
    for (std::size_t i = 0; i < polyhedron.normal.size(); ++i) {
      if ((set >> i) % 2 == 1) rows.push_back(i);
    }
    LongVector z{};
    if (!polyhedron.project(rows, z) || !polyhedron.contains(z)) continue;
    const long double distance = distance_squared(z, polyhedron.target);
    if (distance < best) {
      best = distance;
      best_z = z;
    }
  }
  ExhaustiveOptimum optimum;
  optimum.feasible = best < kInfinity;
  for (std::size_t k = 0; k < size_of(problem.unknowns); ++k) {
    optimum.x[k] = best_z[k] / root_weight(problem, k);
  }
  return optimum;
}

long double scaled_difference(const QpProblem& problem, const QpSolution& a, const QpSolution& b) {
  long double difference = 0.0L;
  long double size = 1e-300L;
  for (std::size_t k = 0; k < size_of(problem.unknowns); ++k) {
    const long double root = root_weight(problem, k);
    const long double za = root * a.x[k];
    difference = std::max(difference, std::abs(za - root * b.x[k]));
    size = std::max({size, std::abs(za), std::abs(root * problem.target[k])});
  }
  return difference / size;
}

}  // namespace hapticd::test
