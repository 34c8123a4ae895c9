// What clients are told of the recorder. Not RT.
#pragma once

#include "hapticd/v1/answer.pb.h"
#include "server/recorder/recorder.h"

namespace hapticd {

/// `status` on the wire.
[[nodiscard]] v1::RecordInfo record_info(const RecordStatus& status);

}  // namespace hapticd
