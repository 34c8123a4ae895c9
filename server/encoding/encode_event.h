// Events of the loop as Items of the wire. Not RT.
#pragma once

#include <optional>
#include <string_view>

#include "core/simulation/touch_detector.h"
#include "core/tick/cause.h"
#include "core/tick/string_event.h"
#include "hapticd/v1/stream.pb.h"
#include "server/encoding/scene_index.h"

namespace hapticd {

/// Where in the run of the loop something happened.
struct EventPlace {
  std::uint64_t tick = 0;
  std::int64_t t_ns = 0;  ///< of the tick
  std::uint32_t tool_id = 0;
};

/// The Item of a string's event; none for what clients are not sent.
[[nodiscard]] std::optional<v1::Item> encode_event(const StringEvent& event,
                                                   const EventPlace& place,
                                                   const SceneIndex& index);

/// The Item of a touch of a body or line.
[[nodiscard]] v1::Item encode_event(const TouchEvent& event, const EventPlace& place,
                                    const SceneIndex& index);

/// The Item of a fault, latched or cleared.
[[nodiscard]] v1::Item encode_fault(Cause cause, bool latched, const EventPlace& place);

/// For people: what the cause means, and the remedy.
[[nodiscard]] std::string_view explain(Cause cause) noexcept;

}  // namespace hapticd
