// A tick as the loop leaves it (TickTrace) in the form it is recorded in (TickRecord), and back:
// every double keeps its bits. Not RT.
#pragma once

#include "hapticd/v1/recording.pb.h"
#include "server/haptic_loop/tick_trace.h"

namespace hapticd {

/// Fills `record`, whose storage is used again.
void to_record(const TickTrace& trace, v1::TickRecord& record);

/// False when `record` cannot be a tick of ours: more tools than a trace holds, inputs and outputs
/// that do not match, or numbers missing.
[[nodiscard]] bool to_trace(const v1::TickRecord& record, TickTrace& trace);

}  // namespace hapticd
