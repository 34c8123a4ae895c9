// The pairs of tool and obstacles that a linearisation may come to: found by a traversal around the
// tool, and evaluated afresh as it moves on. A tool looks no farther than hand and tool go; what is
// farther bears no force yet, and no step goes there before it has been looked at. RT: yes.
#pragma once

#include "core/contact/contact_problem.h"
#include "core/math/realtime.h"

namespace hapticd {

/// Fills `workspace.contacts` with the pairs around `state.X_WG`, with the bounds of coarse levels
/// unless `workspace.leaves`; `reach_wanted` (m): how far the tool would go if nothing was in its
/// way. A short work budget leaves the farthest out.
HD_REALTIME void find_candidates(const ContactInput& input, const ContactState& state,
                                 double reach_wanted, OptimiserWorkspace& workspace,
                                 ContactResult& result) noexcept;

/// The contacts at the pose just committed: the same pairs afresh, or a new traversal once the tool
/// has moved out of their range; nothing where they are of this pose.
HD_REALTIME void refresh_candidates(const ContactInput& input, const ContactState& state,
                                    double reach_wanted, OptimiserWorkspace& workspace,
                                    ContactResult& result) noexcept;

/// Tests that the next linearisation begins with, as many as the last traversal took, where it has
/// to look around anew; otherwise 0.
[[nodiscard]] HD_REALTIME std::int64_t tests_of_next_look(
    const OptimiserWorkspace& workspace) noexcept;

}  // namespace hapticd
