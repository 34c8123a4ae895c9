// From the message to core: a filled scene becomes a SceneDescription. Offline.
#pragma once

#include "core/scene/scene_description.h"
#include "hapticd/v1/scene.pb.h"
#include "server/scene_io/model_files.h"
#include "server/scene_io/scene_problem.h"

namespace hapticd {

/// Translates `scene`, whose defaults are filled in and whose fields are in range. What cannot be
/// (files that are missing, shapes without spheres, features that others need) is added to
/// `problems` with its path. `device_stiffness` (N/m) is used where k_s_from_device gives none.
[[nodiscard]] SceneDescription translate_scene(const v1::Scene& scene, double device_stiffness,
                                               ModelFiles& files, SceneProblems& problems);

}  // namespace hapticd
