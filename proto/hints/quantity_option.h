// Numbers with units on a command line: --delay 20ms where seconds are asked for. Not RT.
#pragma once

#include <CLI/App.hpp>

namespace hapticd::hints {

/// The number that `option` asks for is in `unit`, as parse_quantity() knows it or "dB", and
/// may be given with that unit or with another of its kind. Checks of `option` see the number in
/// `unit`, whether they were added before or after. Returns `option`.
CLI::Option* takes_unit(CLI::Option* option, const char* unit);

}  // namespace hapticd::hints
