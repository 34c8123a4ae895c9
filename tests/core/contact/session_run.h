// Plays a contact session through the contact problem and compares the forces of two runs. Shared
// by the test of the default options and the table of what every option buys.
#pragma once

#include <span>
#include <vector>

#include "core/contact/contact_problem.h"
#include "core/instrument/string_parameters.h"
#include "tests/support/contact_sessions.h"

namespace hapticd::test {

/// What the lines of a session are when they are strings.
struct SessionStrings {
  StringParameters parameters;
  InstrumentOptions instrument;
};

/// What one run of a session gave, tick by tick.
struct SessionRun {
  std::vector<Vector3> f_H_W;        ///< N; tick k is at t = k / rate
  std::vector<double> microseconds;  ///< wall clock of each tick
  std::vector<std::int64_t> work;    ///< of each tick
  int most_sub_steps = 0;
};

/// Plays `session` at `rate_hz` ticks per second, starting where G and H coincide.
/// `work_budget` is that of every tick, 0: none. With `lines` the session's lines are strings of
/// these parameters, their ends and radius aside.
[[nodiscard]] SessionRun play(const ContactSession& session, const ContactOptions& options,
                              double rate_hz, const SessionStrings* lines = nullptr,
                              std::int64_t work_budget = 0);

/// How far forces are from a reference of the same length.
struct ForceError {
  double rms_percent = 0.0;    ///< rms error over rms reference
  double max_newton = 0.0;     ///< greatest single error
  double largest_force = 0.0;  ///< of the reference, N
};

[[nodiscard]] ForceError force_error(std::span<const Vector3> f_H_W,
                                     std::span<const Vector3> reference);

}  // namespace hapticd::test
