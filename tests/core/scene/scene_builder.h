// Small descriptions of scenes for tests. Not RT.
#pragma once

#include <vector>

#include "core/scene/scene_description.h"

namespace hapticd::test {

/// A shape of spheres as written.
[[nodiscard]] ShapeDescription shape_of(const std::vector<Sphere>& spheres);

/// A rigid part.
[[nodiscard]] PartDescription part_of(const std::vector<Sphere>& spheres, const Pose& X_GP = {});

/// A finger of one sphere of 5 mm at `p_WG`, in an empty scene.
[[nodiscard]] SceneDescription finger_scene(const Vector3& p_WG = {0.0, 0.0, 0.0});

/// A string with the defaults.
[[nodiscard]] StringDescription string_between(const Vector3& p_WA, const Vector3& p_WB);

}  // namespace hapticd::test
