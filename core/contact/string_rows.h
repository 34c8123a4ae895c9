// Which rows a program of many strings holds and in what order, where the strings are eliminated
// from its model. RT: yes.
#pragma once

#include "core/contact/contact_problem.h"

namespace hapticd {

/// Puts the first `pressed` rows in the order of their strings, in which the solver passes over
/// most of what is zero.
HD_REALTIME void sort_by_string(std::size_t pressed, OptimiserWorkspace& workspace) noexcept;

/// Of the first `violated` contacts in workspace.order, leaves of each held string the worst alone:
/// where many strings are met at once, their other pairs mostly hold with it; none of a string that
/// the solution holds off already but for a small share of the skin. Returns how many are left.
[[nodiscard]] HD_REALTIME std::size_t keep_worst_of_strings(const ContactState& state, double skin,
                                                            std::size_t violated,
                                                            OptimiserWorkspace& workspace) noexcept;

}  // namespace hapticd
