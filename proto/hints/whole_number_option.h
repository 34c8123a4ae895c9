// Whole numbers on a command line: CLI11 takes -1 as the largest of the type, cuts what is too
// large, and reads 010 as 8. Not RT.
#pragma once

#include <CLI/App.hpp>
#include <cstdint>

namespace hapticd::hints {

/// `option` takes whole numbers from `lowest` to `highest`, in decimal digits: its value, which is
/// to have room for `highest`, sees nothing else. Returns `option`.
CLI::Option* takes_whole_number(CLI::Option* option, std::uint64_t lowest, std::uint64_t highest);

}  // namespace hapticd::hints
