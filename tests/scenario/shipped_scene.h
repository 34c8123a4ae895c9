// The scenes of deploy/scenes with the models of this build. Not RT.
#pragma once

#include <memory>
#include <string>

#include "server/scene_io/scene_loader.h"

namespace hapticd::test {

/// Where they are.
[[nodiscard]] LoadOptions shipped();

/// True when the trees of guqin_fine were made too.
[[nodiscard]] bool fine_models_exist();

/// Loads one; fails the test with all problems when there is any.
[[nodiscard]] std::unique_ptr<LoadedScene> load_shipped(const std::string& name);

/// Pose at `p` with the orientation of `X`.
[[nodiscard]] Pose moved_to(const Pose& X, const Vector3& p);

}  // namespace hapticd::test
