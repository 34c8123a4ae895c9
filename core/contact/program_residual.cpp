// See program_residual.h. RT: yes.
#include "core/contact/program_residual.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/contact/coupling_axes.h"

namespace hapticd {
namespace {

/// Of the tool, as a force at the coupling's length.
double as_force(const CouplingStiffness& stiffness, const Vector3& dp,
                const Vector3& dtheta) noexcept {
  const double turned = stiffness.length * dtheta.norm();
  if (stiffness.per_axis) {
    return std::max(stiffness.along_W().cwiseProduct(dp).norm(), stiffness.kt * turned);
  }
  return stiffness.kt * std::max(dp.norm(), turned);
}

/// Stationarity: x - target - sum of multiplier row / weight, in the tool's own coordinates.
double stationarity(const QpProblem& problem, const QpSolution& solution,
                    const Linearisation& model, const CouplingStiffness& stiffness) noexcept {
  const SquareMatrix& basis = model.basis();
  std::array<double, kToolDof> way{};
  for (std::size_t k = 0; k < basis.size; ++k) {
    double off = 0.0;
    for (int a = 0; a < solution.active_count; ++a) {
      const auto i = static_cast<std::size_t>(a);
      off += solution.multiplier[i] * problem.row[k][static_cast<std::size_t>(solution.active[i])];
    }
    off = solution.x[k] - problem.target[k] - off / problem.weight[k];
    for (std::size_t j = 0; j < way.size(); ++j) way[j] += basis(j, k) * off;
  }
  return as_force(stiffness, {way[0], way[1], way[2]}, {way[3], way[4], way[5]});
}

}  // namespace

ProgramResidual program_residual(const QpProblem& problem, const QpSolution& solution,
                                 const Linearisation& model,
                                 const CouplingStiffness& stiffness) noexcept {
  ProgramResidual residual;
  residual.force = stationarity(problem, solution, model, stiffness);
  const auto rows = static_cast<std::size_t>(problem.rows);
  std::array<double, kMaxQpRows> lacking;
  std::copy_n(problem.bound.begin(), rows, lacking.begin());
  for (std::size_t k = 0; k < static_cast<std::size_t>(problem.unknowns); ++k) {
    const double x = solution.x[k];
    const double* const row = problem.row[k].data();
    for (std::size_t r = 0; r < rows; ++r) lacking[r] -= row[r] * x;
  }
  for (std::size_t r = 0; r < rows; ++r) residual.gap = std::max(residual.gap, lacking[r]);
  for (int a = 0; a < solution.active_count; ++a) {
    const auto r = static_cast<std::size_t>(solution.active[static_cast<std::size_t>(a)]);
    residual.gap = std::max(residual.gap, std::abs(lacking[r]));
  }
  return residual;
}

double unbalanced_force(const CouplingStiffness& stiffness, const Quaternion& q_WH,
                        const PoseError& error_GH, const Wrench& F_H_W) noexcept {
  if (stiffness.per_axis) {
    const Wrench pull = axes::pull(stiffness, q_WH, error_GH);
    return std::max((pull.f + F_H_W.f).norm(), (pull.t + F_H_W.t).norm() / stiffness.length);
  }
  return as_force(stiffness, error_GH.dp + F_H_W.f / stiffness.kt,
                  error_GH.dtheta + F_H_W.t / stiffness.kr());
}

}  // namespace hapticd
