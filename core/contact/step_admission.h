// Which part of the full step of a linearisation may be committed: as far as the pairs known reach,
// and halved until the exact gaps on the way of tool and strings are not negative and the energy
// does not climb. RT: yes; about 50 ns per pair the step could close.
#pragma once

#include "core/contact/contact_problem.h"

namespace hapticd {

/// Upper bound of the way of any point of the tool relative to any of a string in `step`, m.
[[nodiscard]] HD_REALTIME double step_bound(const ContactInput& input, const ContactState& state,
                                            const ConfigurationStep& step) noexcept;

/// Commits what of w.step is admissible, no more than `holds` of it. The `last` step of a tick,
/// which is within the tolerance, is worth one try. False when nothing is admissible: the
/// configuration stays.
HD_REALTIME bool commit_admissible(const ContactInput& input, const PoseError& error_GH,
                                   double holds, bool last, ContactState& state,
                                   OptimiserWorkspace& w, ContactResult& result) noexcept;

}  // namespace hapticd
