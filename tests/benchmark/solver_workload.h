// The problems the solver is timed on and its instructions are counted on: seeded contact problems,
// cold, or warm with the active rows of their slightly different predecessor. Not RT.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "core/solver/active_set.h"
#include "tests/support/qp_families.h"

namespace hapticd::test {

struct SolverWorkload {
  std::vector<QpProblem> problem;
  std::vector<QpWarmStart> warm;
  QpWorkspace workspace;
  QpSolution solution;

  /// Solves problem i modulo their number.
  void solve(std::size_t i) {
    const std::size_t p = i % problem.size();
    solve_qp(problem[p], warm[p], workspace, solution);
  }
};

inline std::unique_ptr<SolverWorkload> make_solver_workload(std::size_t problems, int rows,
                                                            bool warm) {
  auto workload = std::make_unique<SolverWorkload>();
  workload->problem.resize(problems);
  workload->warm.resize(problems);
  SplitMix64 random(1);
  for (std::size_t i = 0; i < problems; ++i) {
    contact_problem(random, rows, workload->problem[i]);
    if (!warm) continue;
    workload->solve(i);
    const QpSolution& solution = workload->solution;
    workload->warm[i].count = solution.active_count;
    workload->warm[i].active = solution.active;
    move_contacts(random, workload->problem[i]);
  }
  return workload;
}

}  // namespace hapticd::test
