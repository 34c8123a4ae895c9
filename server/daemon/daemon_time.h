// Who steps the loop: a thread of its own, the daemon, or a recording. Not RT.
#pragma once

#include <variant>

#include "server/daemon/real_time.h"
#include "server/daemon/replay_time.h"
#include "server/daemon/virtual_time.h"

namespace hapticd {

/// All have start(), pass() and over().
using DaemonTime = std::variant<RealTime, VirtualTime, ReplayTime>;

}  // namespace hapticd
