// The press of tests/support/string_truth.h played with the models of core/instrument: shared by
// the test of their accuracy and the table of tests/benchmark. Not RT.
#pragma once

#include <vector>

#include "core/instrument/string_parameters.h"
#include "tests/support/string_truth.h"

namespace hapticd::test {

/// A string, what happens to it, and the force it answers with.
struct PressCase {
  StringConstants string;
  TruthString truth_string;
  TruthPress press;
  std::vector<double> truth;  ///< mean force of each tick, N
};

/// A string of 1.1 m and 30 N, plucked by 5 mm at `pluck_lambda`, pressed by a finger of
/// `stiffness` (N/m) as TruthPress says. The truth has 256 modes at `rate` samples per second.
PressCase make_press_case(double frequency, double pluck_lambda, double stiffness, int rate);

struct PressRun {
  std::vector<double> force;        ///< of each tick, N
  std::vector<double> nanoseconds;  ///< wall time of each tick in which the finger presses
};

/// The string with modes; `steps` contact steps per tick.
PressRun play_modal(const PressCase& press_case, int modes, int steps);

/// The static force, with `vibrates` on it the fundamental as Eq. 9 is printed: r_max is the whole
/// depth of the pluck, stiffness and T_d are as if nobody touched the string, and nothing keeps the
/// sum from attracting.
PressRun play_printed(const PressCase& press_case, bool vibrates);

struct PressError {
  double rms_percent;  ///< of the truth's rms force
  double max_newton;
};

PressError press_error(const PressRun& run, const PressCase& press_case);

}  // namespace hapticd::test
