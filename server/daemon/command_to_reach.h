// The command that a person types to reach this daemon. Not RT.
#pragma once

#include <string>

namespace hapticd {

/// `hapticctl status` with the options that reach a daemon on `address` (HOST:PORT, as bound) from
/// any folder of this machine, for a shell. `keys`: the folder of its keys, or empty.
[[nodiscard]] std::string command_to_reach(const std::string& address, const std::string& keys);

}  // namespace hapticd
