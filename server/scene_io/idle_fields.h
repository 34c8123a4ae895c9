// What a scene says without effect: features, settings and constants that nothing in it uses. Not
// wrong, but whoever wrote them expects something of them. Offline.
#pragma once

#include "core/scene/scene_description.h"
#include "hapticd/v1/scene.pb.h"
#include "server/scene_io/scene_problem.h"

namespace hapticd {

/// A doubt for each field of `written`, the scene as its author wrote it, that changes no wrench,
/// no State and no event (but the decay time of a string that is still), as long as the scene is
/// played as loaded. `scene` is its translation. Some that do nothing are not found: a body out of
/// reach.
[[nodiscard]] SceneProblems idle_fields(const v1::Scene& written, const SceneDescription& scene);

}  // namespace hapticd
