// Commands that are hapticd's own, started by hapticctl in its place: no daemon has to run for
// them. Not RT.
#pragma once

#include <string>
#include <vector>

namespace hapticd::ctl {

/// Becomes hapticd with these arguments: the program beside this one, else that of PATH. Its exit
/// code is then hapticctl's. Returns only by throwing Failure(kRefused), when there is no hapticd.
[[noreturn]] void become_hapticd(const std::vector<std::string>& arguments);

}  // namespace hapticd::ctl
