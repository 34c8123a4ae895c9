// The paths that a run of the daemon reaches: what it was told to read, where it records, devices,
// and what its libraries read. Not RT.
#pragma once

#include <vector>

#include "server/confinement/landlock.h"
#include "server/daemon/daemon_options.h"

namespace hapticd {

/// Of the options, settled. Makes the folder that recordings and checks of devices go to, if it can
/// be made: a folder that is not there cannot be told to the kernel.
[[nodiscard]] std::vector<ReachedPath> reached_paths(const DaemonOptions& options);

}  // namespace hapticd
