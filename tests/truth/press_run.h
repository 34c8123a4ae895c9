// The press of string_truth.h played with the models of core/instrument: for hapticd-oracle, the
// test of their accuracy and the table of tests/benchmark. Not RT.
#pragma once

#include <vector>

#include "core/instrument/instrument_options.h"
#include "core/instrument/string_parameters.h"
#include "tests/truth/string_truth.h"

namespace hapticd {

/// A string, what happens to it, and the force it answers with.
struct PressCase {
  StringConstants string;
  TruthString truth_string;
  TruthPress press;
  std::vector<double> truth;  ///< mean force of each tick, N
};

/// The core's string for `string`, without the truth.
PressCase press_case_of(const TruthString& string, const TruthPress& press);

/// The truth of 256 modes at `rate` samples per second.
void find_truth(int rate, PressCase& press_case);

/// A string of 1.1 m and 30 N, plucked by 5 mm at `pluck_lambda`, pressed by a finger of
/// `stiffness` (N/m) as TruthPress says, which does not damp it, with the truth.
PressCase make_press_case(double frequency, double pluck_lambda, double stiffness, int rate);

struct PressRun {
  std::vector<double> force;        ///< of each tick, N
  std::vector<double> nanoseconds;  ///< wall time of each tick in which the finger presses
};

/// The string that sounds, drawn aside and let go at once.
PressRun play_wave(const PressCase& press_case, int modes);

/// The static force, with `vibrates` on it the fundamental as Eq. 9 is printed: r_max is the whole
/// depth of the pluck, stiffness and T_d are as if nobody touched the string, and nothing keeps the
/// sum from attracting.
PressRun play_printed(const PressCase& press_case, bool vibrates);

/// The ladder of core/instrument as a session climbs it, by the hand's ticks alone: the pluck is a
/// hand that slips off the string. What rings is what its release detector makes of that, or, with
/// modes, what the hand has left in them.
PressRun play_ladder(const PressCase& press_case, const InstrumentOptions& options);

/// Mean frequency of the fundamental, without further modes, on that ladder in the first `seconds`
/// after the pluck of `press_case`, Hz; 0 where nothing rings.
double ladder_frequency(const PressCase& press_case, const InstrumentOptions& options,
                        double seconds);

struct PressError {
  double rms_percent;  ///< of the truth's rms force
  double max_newton;
};

PressError press_error(const PressRun& run, const PressCase& press_case);

}  // namespace hapticd
