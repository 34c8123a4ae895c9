// A scene that uses every message of scene.proto, and the means to load it. Not RT.
#pragma once

#include <string>

#include "server/scene_io/scene_loader.h"

namespace hapticd::test {

/// The text of it. Needs no file.
[[nodiscard]] const std::string& full_scene_text();

/// The same as a message.
[[nodiscard]] v1::Scene full_scene();

/// In protobuf text format.
[[nodiscard]] std::string print_scene(const v1::Scene& scene);

/// Loads inline text without any folder to look into.
[[nodiscard]] LoadResult load_inline(const std::string& text);

/// The problems, one a line, for messages of tests.
[[nodiscard]] std::string list(const SceneProblems& problems);

/// The first fault whose field is `path`; null when there is none.
[[nodiscard]] const SceneProblem* find_fault(const SceneProblems& problems,
                                             const std::string& path);

/// A tool of one sphere, the least that a scene needs.
inline const std::string kOneSphereTool =
    "tools { name: \"t\" parts { name: \"p\" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 "
    "} } } pose_wg { p_m: [0, 1, 0] } }\n";

}  // namespace hapticd::test
