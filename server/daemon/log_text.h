// Lines of the realtime log as text. Not RT.
#pragma once

#include "core/rt/rt_log.h"

namespace hapticd {

/// Writes the record's line to the log, formatted.
void write_log(const LogRecord& record);

}  // namespace hapticd
