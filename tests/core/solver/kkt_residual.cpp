// Plain sums over the problem as given; shares nothing with the solver.
#include "tests/core/solver/kkt_residual.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace hapticd {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Larger of the two; a value that is not a number counts as infinite.
double worse(double residual, double value) noexcept {
  if (value <= residual) return residual;
  return value > residual ? value : kInfinity;
}

struct Scaled {
  std::array<double, kMaxQpUnknowns> root_weight;
  /// sum of multiplier_i row_i - weight (x - target), in the scaled space.
  std::array<double, kMaxQpUnknowns> imbalance;
  double scale = 1e-300;  ///< max(|z|, |z_target|)
};

double length_of_row(const QpProblem& problem, const Scaled& scaled, std::size_t i) noexcept {
  double squared = 0.0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(problem.unknowns); ++k) {
    const double c = problem.row[k][i] / scaled.root_weight[k];
    squared += c * c;
  }
  return std::sqrt(squared);
}

double slack_of_row(const QpProblem& problem, const QpSolution& solution, std::size_t i) noexcept {
  double slack = -problem.bound[i];
  for (std::size_t k = 0; k < static_cast<std::size_t>(problem.unknowns); ++k) {
    slack += problem.row[k][i] * solution.x[k];
  }
  return slack;
}

Scaled scale_point(const QpProblem& problem, const QpSolution& solution) noexcept {
  Scaled scaled;
  double z_squared = 0.0;
  double target_squared = 0.0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(problem.unknowns); ++k) {
    const double root = std::sqrt(problem.weight[k]);
    scaled.root_weight[k] = root;
    scaled.imbalance[k] = -root * (solution.x[k] - problem.target[k]);
    z_squared += root * solution.x[k] * (root * solution.x[k]);
    target_squared += root * problem.target[k] * (root * problem.target[k]);
  }
  scaled.scale = std::max({std::sqrt(z_squared), std::sqrt(target_squared), 1e-300});
  return scaled;
}

/// Violation of row i, relative; a zero row with a positive bound can never hold.
double primal_residual(const QpProblem& problem, const QpSolution& solution, const Scaled& scaled,
                       std::size_t i) noexcept {
  const double slack = slack_of_row(problem, solution, i);
  if (slack >= 0.0) return 0.0;
  const double length = length_of_row(problem, scaled, i);
  if (!(length > 0.0)) return kInfinity;
  return -slack / std::max(length * scaled.scale, std::fabs(problem.bound[i]));
}

}  // namespace

double kkt_residual(const QpProblem& problem, const QpSolution& solution) noexcept {
  if (solution.active_count < 0 || solution.active_count > problem.unknowns) return kInfinity;
  Scaled scaled = scale_point(problem, solution);
  double residual = 0.0;
  double multiplier_sum = 0.0;
  for (std::size_t j = 0; j < static_cast<std::size_t>(solution.active_count); ++j) {
    if (solution.active[j] < 0 || solution.active[j] >= problem.rows) return kInfinity;
    const auto i = static_cast<std::size_t>(solution.active[j]);
    const double length = length_of_row(problem, scaled, i);
    const double multiplier = solution.multiplier[j] * length;
    const double slack = slack_of_row(problem, solution, i) / length;
    multiplier_sum += std::fabs(multiplier);
    residual = worse(residual, -multiplier / scaled.scale);
    residual = worse(residual, std::min(multiplier, slack) / scaled.scale);
    for (std::size_t k = 0; k < static_cast<std::size_t>(problem.unknowns); ++k) {
      scaled.imbalance[k] += solution.multiplier[j] * problem.row[k][i] / scaled.root_weight[k];
    }
  }
  double imbalance_squared = 0.0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(problem.unknowns); ++k) {
    imbalance_squared += scaled.imbalance[k] * scaled.imbalance[k];
  }
  residual = worse(residual, std::sqrt(imbalance_squared) / std::max(scaled.scale, multiplier_sum));
  for (std::size_t i = 0; i < static_cast<std::size_t>(problem.rows); ++i) {
    residual = worse(residual, primal_residual(problem, solution, scaled, i));
  }
  return residual;
}

}  // namespace hapticd
