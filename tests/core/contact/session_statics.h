// A contact session beside the exact statics (tests/truth/exact_statics.h) of every place of the
// hand: what a hand would feel that moves so slowly that every rest is reached. Not RT: about 1 ms
// per tick.
#pragma once

#include "tests/core/contact/session_run.h"

namespace hapticd::test {

/// What came of the comparison.
struct StaticsError {
  ForceError force;
  int ticks = 0;   ///< compared
  int others = 0;  ///< of them compared with another rest than the one that follows from the last
  int slips = 0;   ///< ticks in which the exact rest jumps
  bool converged = true;  ///< every exact rest that was used
};

/// Plays `session` at `rate_hz` with the default options. A tool may slip to a rest that following
/// the last exact rest does not lead to, or a tick sooner or later: then what counts is the exact
/// rest downhill of where the tool is, or that beside the jump, and `others` says how often.
/// `fattening`: of the truth's surfaces, m.
[[nodiscard]] StaticsError compare_with_statics(const ContactSession& session, double rate_hz,
                                                const SessionStrings* lines = nullptr,
                                                double fattening = 0.0);

}  // namespace hapticd::test
