// What a start would refuse, found without opening or making anything: for --check. Not RT.
#pragma once

#include <string>

#include "hapticd/v1/config.pb.h"
#include "server/daemon/stop_opening.h"

namespace hapticd {

/// Refuses what --listen, --stop-listen and --record cannot be started with, as far as it can be
/// told. Throws StartError with the code and words of the start.
void check_start(const v1::Config& config, const StopPlan& stop);

/// Why a new file `path` cannot be made, as far as can be told: what is wrong with it or the folder
/// it is to be in. Folders that are missing can be made. Empty: nothing is.
[[nodiscard]] std::string fault_of_new_file(const std::string& path);

}  // namespace hapticd
