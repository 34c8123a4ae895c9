// From contacts to rows of the quadratic program: n . dp + (a x n) . dtheta >= skin - gap, a the
// lever arm from the origin of G to the contact point, or >= min(0, skin - gap) where obstacles
// leave no room for the skin; a string that yields takes its share of the deflections with it,
// - share n . du, and its vertex slides along with the centre of its contact. When
// more pairs matter than there are rows, the nearest are taken first and rows are exchanged until
// no pair left out is violated. RT: yes.
#pragma once

#include "core/rendering/configuration_optimiser.h"

namespace hapticd {

/// Exchange rounds at most; normal 0. When used up, the step is shortened instead (safe, slower).
inline constexpr int kMaxExchangeRounds = 8;

/// Solves the program of the current linearisation with the full target `e` over ALL contacts of
/// the workspace; the solution's rows are named by workspace.contact_of_row. Returns the fraction
/// of the solution that satisfies every row, those left out included (1 normally; 0 when the solver
/// failed).
[[nodiscard]] HD_REALTIME double solve_linearisation(const OptimiserInput& input,
                                                     const OptimiserState& state, const ToolStep& e,
                                                     OptimiserWorkspace& workspace,
                                                     OptimiserResult& result) noexcept;

}  // namespace hapticd
