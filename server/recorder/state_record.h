// Snapshots of the loop's state as Snapshots of recording.proto and back, and settings as blocks of
// ParameterRecords. Numbers keep their bits; what is read is not trusted. Not RT.
#pragma once

#include <string>
#include <string_view>

#include "core/scene/scene_settings.h"
#include "hapticd/v1/recording.pb.h"
#include "server/haptic_loop/snapshot.h"

namespace hapticd {

/// Name of a block, such as "tool".
[[nodiscard]] std::string_view block_name(StateKind kind) noexcept;

/// All of `snapshot` but parameters.
void to_record(const Snapshot& snapshot, v1::Snapshot& record);

/// False when the record has blocks that this version does not know, or more than a snapshot holds;
/// `snapshot` is of no use then.
[[nodiscard]] bool to_snapshot(const v1::Snapshot& record, Snapshot& snapshot);

/// True when the state is one of an older version, which had another layout.
[[nodiscard]] bool is_of_older_layout(const v1::Snapshot& record);

/// The first block in which the two differ, such as "string 3"; empty when all bits are equal.
[[nodiscard]] std::string first_difference(const Snapshot& recorded, const Snapshot& replayed);

/// What a change leads to, as `record`'s blocks.
void put_settings(const SceneSettings& settings, v1::ParameterRecord& record);

/// What `record` leads to, into settings of as many tools and strings. False when they do not
/// match, or a number is out of its range.
[[nodiscard]] bool get_settings(const v1::ParameterRecord& record, SceneSettings& settings);

}  // namespace hapticd
