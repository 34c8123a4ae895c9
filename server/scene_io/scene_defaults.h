// Fills in what a scene leaves out, so that the message says all that is played: what SceneInfo
// shows, and what is translated. Features that are absent stay absent. Offline.
#pragma once

#include <optional>

#include "hapticd/v1/scene.pb.h"

namespace hapticd {

/// Sets every absent number, choice and pose of `scene` to its default. `preset`, where given,
/// replaces the scene's and every field a preset decides, set or not.
void fill_defaults(std::optional<v1::Preset> preset, v1::Scene& scene);

/// The rung of the ladder of core/scene/quality.h that `quality` asks for.
[[nodiscard]] int quality_level(const v1::Quality& quality);

}  // namespace hapticd
