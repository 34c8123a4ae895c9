// Events of the loop as Items of the wire. Not RT.
#pragma once

#include <optional>
#include <string_view>

#include "hapticd/v1/stream.pb.h"
#include "server/encoding/scene_index.h"
#include "server/haptic_loop/loop_event.h"

namespace hapticd {

/// The Item of `event`; none for what clients are not told. `index` is that of the event's scene.
[[nodiscard]] std::optional<v1::Item> encode_event(const LoopEvent& event, const SceneIndex& index);

/// For people: what the cause means, and the remedy.
[[nodiscard]] std::string_view explain(Cause cause) noexcept;

}  // namespace hapticd
