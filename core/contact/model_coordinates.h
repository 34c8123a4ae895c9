// From the unknowns y of a linearisation to the coordinates z in which its model is round, and
// back: the rows and the solution of the program. RT: yes.
#pragma once

#include "core/contact/contact_problem.h"

namespace hapticd {

/// What a row asks of a string.
struct StringTerm {
  std::size_t row;
  std::size_t unknown;  ///< of the radial deflection
  double radial;
  double tangential;
};

/// Adds it to the row.
HD_REALTIME void add_string(const StringTerm& term, const LocalModel& model,
                            QpProblem& problem) noexcept;

/// Unknowns, weights and target of the problem.
HD_REALTIME void set_objective(const LocalModel& model, QpProblem& problem) noexcept;

/// The unknowns that the solution means.
HD_REALTIME void find_unknowns(const QpSolution& solution, const LocalModel& model,
                               std::array<double, kMaxQpUnknowns>& y) noexcept;

}  // namespace hapticd
