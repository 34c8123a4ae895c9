// What takes the place of an Item that cannot be sent, because a blob would be too long or too
// many bytes of blobs wait already. PROTOCOL.md, section 5. Not RT.
#pragma once

#include <optional>

#include "hapticd/v1/stream.pb.h"

namespace hapticd {

/// Of a SceneInfo one without the scene's contents; of a Result one without payload, FAILED where
/// it was OK, with path and message as long as they may be. At most 1000 bytes. Nothing: only a
/// SceneInfo or a Result is ever this long.
[[nodiscard]] std::optional<v1::Item> notice_for(const v1::Item& item);

}  // namespace hapticd
