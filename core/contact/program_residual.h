// How far the solution of a contact program is from the program's optimum, by the conditions of
// Karush, Kuhn and Tucker, from problem and solution alone: what the solver says of itself has no
// part in it. RT: yes, one pass over the rows.
#pragma once

#include "core/contact/linearisation.h"
#include "core/contact/virtual_coupling.h"

namespace hapticd {

struct ProgramResidual {
  /// Stationarity: coupling stiffness times the way of the tool between x and where the
  /// multipliers' forces balance, of rotation at the coupling's length; N. Where axes differ,
  /// rotation counts as about the stiffest.
  double force = 0.0;
  /// Most by which a row is violated, or an active one differs from its bound; m.
  double gap = 0.0;
};

/// Of the program that `model` has set and rows have been added to.
[[nodiscard]] HD_REALTIME ProgramResidual
program_residual(const QpProblem& problem, const QpSolution& solution, const Linearisation& model,
                 const CouplingStiffness& stiffness) noexcept;

/// Without a program's solution: what coupling and `F_H_W` leave over on the tool, N; of torque at
/// the coupling's length.
[[nodiscard]] HD_REALTIME double unbalanced_force(const CouplingStiffness& stiffness,
                                                  const Quaternion& q_WH, const PoseError& error_GH,
                                                  const Wrench& F_H_W) noexcept;

}  // namespace hapticd
