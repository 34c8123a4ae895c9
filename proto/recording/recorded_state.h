// A recorded tick as clients saw it: the State that stands in the recording, completed by what each
// tool was given and gave. Of a recording of format 2, which has none, tools and devices alone.
// Pure. Not RT.
#pragma once

#include "hapticd/v1/recording.pb.h"
#include "hapticd/v1/state.pb.h"

namespace hapticd {

/// All that the recording has of the tick: its State but for times and quality's reason, and what a
/// device measures beside its pose.
[[nodiscard]] v1::State state_of(const v1::TickRecord& tick);

}  // namespace hapticd
