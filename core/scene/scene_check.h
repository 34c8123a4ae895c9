// Whether a scene can be played: what no single number shows. Numbers have ranges, which are
// checked here once more by the functions of the folders that own them. Offline.
#pragma once

#include <string>
#include <vector>

#include "core/scene/scene_description.h"

namespace hapticd {

/// What is wrong with a scene, or doubtful.
struct SceneFinding {
  bool doubt = false;   ///< the scene can be played all the same
  std::string path;     ///< field below Scene, such as "strings[3].tension_n"; may name a message
  std::string message;  ///< what it is, and what it may be
  std::string remedy;   ///< one sentence for people
};

/// Faults of the tools' couplings: axes too far apart, or turning too heavy against moving.
[[nodiscard]] std::vector<SceneFinding> check_couplings(const SceneDescription& scene);

/// Findings in the order of the scene; a scene without faults can be built. A tool that starts
/// inside something is a doubt: it is pushed out. Cost: one query per tool.
[[nodiscard]] std::vector<SceneFinding> check_scene(const SceneDescription& scene);

}  // namespace hapticd
