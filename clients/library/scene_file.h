// A scene in a file of this machine, and the files beside it that it names: read here, and brought
// to a server that has no access to them. PROTOCOL.md, section 10. Not RT.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "clients/library/controller.h"

namespace hapticd::client {

/// Length of a piece of a file, bytes, but for the last one.
inline constexpr std::size_t kAssetPiece = 65'536;
/// Most that the files of one scene have together, bytes.
inline constexpr std::size_t kMaxSceneAssets = std::size_t{64} << 20U;
/// Files that one scene brings.
inline constexpr std::size_t kMaxNamedAssets = 256;

/// A file beside a scene's.
struct SceneAssetFile {
  std::string name;  ///< as the scene has it
  std::string hash;  ///< BLAKE2b-256 of bytes, 32 bytes
  std::string bytes;
};

/// What a server has to be sent.
struct SceneFile {
  std::string text;
  std::vector<SceneAssetFile> assets;  ///< each name once, in the order of the text
};

/// `text` is what is in the file at `path`. Sphere-trees and meshes are those beside it, in its
/// folder or below; a name that has no file there is left to the server, which knows those that are
/// installed. A text that is no scene has none: the server says what is wrong with it. Throws
/// std::runtime_error with file, line and remedy for a file that cannot be read, is empty, or is
/// too much for a server. Reads and hashes at most kMaxSceneAssets.
[[nodiscard]] SceneFile read_scene_file(const std::filesystem::path& path, std::string text);

/// The request that loads it, once the server has its files.
[[nodiscard]] v1::Item load_request(const SceneFile& scene);

/// Hears how far it is: the file, how much of it the server has, and how much it is, bytes.
using AssetProgress =
    std::function<void(const SceneAssetFile& asset, std::size_t there, std::size_t all)>;

/// Sends what the server does not have of the scene's files, under the controller's lease, and each
/// piece within `timeout`. The last Result: the first one that is not OK, if any.
v1::Result bring_assets(Controller& controller, const SceneFile& scene,
                        const AssetProgress& progress = {},
                        std::chrono::nanoseconds timeout = std::chrono::seconds(60));

}  // namespace hapticd::client
