// Commands that are those of another program of ours, started by hapticctl in its place: no daemon
// has to run for them. Not RT.
#pragma once

#include <string>
#include <vector>

namespace hapticd::ctl {

/// Becomes the program of that name with these arguments: the one beside this one, else that of
/// PATH. Its exit code is then hapticctl's. Returns only by throwing Failure(kRefused), when there
/// is no such program.
[[noreturn]] void become_program(const std::string& name,
                                 const std::vector<std::string>& arguments);

/// Becomes hapticd.
[[noreturn]] inline void become_hapticd(const std::vector<std::string>& arguments) {
  become_program("hapticd", arguments);
}

}  // namespace hapticd::ctl
