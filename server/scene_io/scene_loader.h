// Loads a scene from a name, a file or inline text: parsed, checked, filled in and built, or
// refused with every fault in it. Nothing that plays is touched. Offline.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/scene.h"
#include "hapticd/v1/scene.pb.h"
#include "server/scene_io/model_files.h"
#include "server/scene_io/scene_defaults.h"
#include "server/scene_io/scene_problem.h"
#include "server/scene_io/told_scene.h"

namespace hapticd {

struct LoadOptions {
  ScenePaths paths;
  /// Replaces the scene's preset and what presets decide.
  std::optional<v1::Preset> preset;
  /// Largest stiffness of the device, N/m: for k_s_from_device where the scene gives none. Normal
  /// value 1000, that of the common desktop devices.
  double device_stiffness = 1000.0;
  QualityWish quality;
};

/// A scene, ready to play.
struct LoadedScene {
  v1::Scene message;   ///< with every default filled in
  GivenQuality given;  ///< of it, what the text has
  std::unique_ptr<const Scene> scene;
  ContentHash hash{};  ///< of the text and then the hashes of the assets
  std::vector<SceneAsset> assets;
};

struct LoadResult {
  std::unique_ptr<LoadedScene> loaded;  ///< null when there is a fault
  SceneProblems problems;               ///< faults and doubts
};

/// Names of the scenes in the folders of `paths`, in alphabetical order.
[[nodiscard]] std::vector<std::string> list_scenes(const ScenePaths& paths);

/// `source` is the name of an installed scene, or a file: with '/' or ".textproto" in it. Models
/// are looked for beside the file first.
[[nodiscard]] LoadResult load_scene(const std::string& source, const LoadOptions& options);

/// From text that has no file; problems name it "inline".
[[nodiscard]] LoadResult load_scene_text(std::string_view text, const LoadOptions& options);

}  // namespace hapticd
