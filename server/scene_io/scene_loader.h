// Loads a scene from a name, a file or inline text: parsed, checked, filled in and built, or
// refused with every fault in it. Nothing that plays is touched. Offline.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/scene.h"
#include "hapticd/v1/answer.pb.h"
#include "hapticd/v1/scene.pb.h"
#include "server/scene_io/brought_file.h"
#include "server/scene_io/model_files.h"
#include "server/scene_io/scene_defaults.h"
#include "server/scene_io/scene_problem.h"
#include "server/scene_io/told_scene.h"

namespace hapticd {

/// Longest SceneInfo of a scene that is loaded, bytes: a blob of the protocol, and 1 KiB less for
/// what the daemon adds.
inline constexpr std::size_t kMaxSceneInfo = (std::size_t{4} << 20U) - 1024;

struct LoadOptions {
  ScenePaths paths;
  /// Replaces the scene's preset and what presets decide.
  std::optional<v1::Preset> preset;
  /// Largest stiffness of the device, N/m: for k_s_from_device where the scene gives none. Normal
  /// value 1000, that of the common desktop devices.
  double device_stiffness = 1000.0;
  QualityWish quality;
  /// Longest SceneInfo of the scene, bytes: a longer one cannot be sent to clients.
  std::size_t longest_info = kMaxSceneInfo;
  /// Come before those in folders.
  BroughtFiles brought;
};

/// A scene, ready to play.
struct LoadedScene {
  v1::Scene message;   ///< with every default filled in
  GivenQuality given;  ///< of it, what the text has
  std::unique_ptr<const Scene> scene;
  ContentHash hash{};  ///< of the text and then the hashes of the assets
  std::vector<SceneAsset> assets;
  BroughtFiles brought;  ///< as in LoadOptions: whoever sends it back need not bring them again
};

struct LoadResult {
  std::unique_ptr<LoadedScene> loaded;  ///< null when there is a fault
  SceneProblems problems;               ///< faults and doubts
  bool missing = false;                 ///< there is no such scene: nothing could be read
};

/// What clients are sent of the scene: message, hash, assets and live parameters.
[[nodiscard]] v1::SceneInfo describe_scene(const LoadedScene& loaded);

/// `name` is that of an installed scene.
[[nodiscard]] LoadResult load_installed_scene(const std::string& name, const LoadOptions& options);

/// `source` is the name of an installed scene, or a file: with '/' or ".textproto" in it. Models
/// are looked for beside the file first. For the owner of the machine, not for peers.
[[nodiscard]] LoadResult load_scene(const std::string& source, const LoadOptions& options);

/// From text that has no file; problems name it "inline".
[[nodiscard]] LoadResult load_scene_text(std::string_view text, const LoadOptions& options);

}  // namespace hapticd
