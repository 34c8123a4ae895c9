// Who came and went, as lines of the log: sessions with keys, by the name of the key. Not RT.
#pragma once

#include <string>

#include "server/network/server_host.h"

namespace hapticd {

/// "key lab-1 (control) at 10.0.0.1:5000"; view.key and control.key by their names.
[[nodiscard]] std::string who_is(const SessionNotice& notice);

/// Writes a line that the session has begun or ended.
void log_session(const SessionNotice& notice);

}  // namespace hapticd
