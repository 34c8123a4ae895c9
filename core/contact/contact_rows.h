// From contacts to rows of the quadratic program: n . dp + (a x n) . dtheta >= skin - gap, a the
// lever arm from the origin of G to the contact point, or >= min(0, skin - gap) where obstacles
// leave no room for the skin; a string that yields takes its share of the deflections with it,
// - share n . du, and its vertex slides along with the centre of its contact. A
// program begins with few rows, those of the pairs that bore force last and of the nearest, and
// rows are exchanged until no pair left out is violated. RT: yes.
#pragma once

#include "core/contact/contact_problem.h"

namespace hapticd {

/// Coefficients of a soft part in a row.
struct PartTerm {
  std::size_t unknown;  ///< first of its three
  Vector3 linear;
};

/// Left-hand coefficients of one contact for the tool, the string it presses and its soft parts,
/// and the right-hand side.
struct ContactRow {
  Vector3 linear;
  Vector3 angular;
  int unknown = -1;  ///< of the string's radial deflection; the tangential one follows; -1: none
  double radial = 0.0;
  double tangential = 0.0;
  std::array<PartTerm, kMaxSoftParts> part;
  std::size_t parts = 0;
  double bound;  ///< what the gap lacks of the skin, m
};

/// The row of `contact`, whose strings and soft parts are modelled in the workspace.
[[nodiscard]] HD_REALTIME ContactRow contact_row(const ContactInput& input,
                                                 const ContactState& state,
                                                 const OptimiserWorkspace& workspace,
                                                 const Contact& contact) noexcept;

/// Exchange rounds at most; normal 0. When used up, the step is shortened instead (safe, slower).
inline constexpr int kMaxExchangeRounds = 8;

/// Solves the program of the current linearisation with the full target `e` over ALL contacts of
/// the workspace; the solution's rows are named by workspace.contact_of_row. Returns the fraction
/// of the solution that satisfies every row, those left out included (1 normally; 0 when the solver
/// failed).
[[nodiscard]] HD_REALTIME double solve_linearisation(const ContactInput& input,
                                                     const ContactState& state,
                                                     const PoseError& error_GH,
                                                     OptimiserWorkspace& workspace,
                                                     ContactResult& result) noexcept;

}  // namespace hapticd
