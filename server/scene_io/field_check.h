// Checks every field of a message against what its comment promises (proto/wire/field_table.h):
// ranges of numbers, shapes of lists, lengths of texts and lists, unknown enum values; and that
// texts are UTF-8. Offline.
#pragma once

#include <google/protobuf/message.h>

#include <string>

#include "server/scene_io/scene_problem.h"

namespace hapticd {

/// Faults of `message`, with paths below it (the message itself is at `path`); files and lines are
/// not filled in. At most 100; what is beyond is not looked at.
[[nodiscard]] SceneProblems check_fields(const google::protobuf::Message& message,
                                         const std::string& path = "");

}  // namespace hapticd
