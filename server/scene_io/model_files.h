// The files a scene is made of: sphere-trees to touch, meshes to draw. Found by plain names among
// those that a peer has brought and below a few folders, read once each. Offline.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "server/scene_io/brought_file.h"
#include "server/scene_io/sphere_tree_file.h"

namespace hapticd {

/// Where scenes and models are looked for, in this order.
struct ScenePaths {
  std::vector<std::filesystem::path> scenes;
  std::vector<std::filesystem::path> models;
};

/// The folders `scenes` and `models` of the installation: those of the environment variable
/// HAPTICD_DATA, else of ../share/hapticd from the program.
[[nodiscard]] ScenePaths installed_paths();

/// A file that a scene names.
struct SceneAsset {
  std::string name;  ///< as the scene has it
  ContentHash hash{};
  std::uint64_t size = 0;  ///< bytes
};

/// Largest file read, bytes: 2^22 spheres and their tree. Larger ones are refused.
inline constexpr std::uintmax_t kMaxModelFile = std::uintmax_t{1} << 28U;

/// All of a regular file; throws std::runtime_error that says why not.
[[nodiscard]] std::vector<std::uint8_t> read_file(const std::filesystem::path& path,
                                                  std::uintmax_t largest);

class ModelFiles {
 public:
  /// A name of `brought` is that file, and is looked for in no folder.
  explicit ModelFiles(std::vector<std::filesystem::path> folders, BroughtFiles brought = {})
      : folders_(std::move(folders)), brought_(std::move(brought)) {}

  /// The sphere-tree in the file `name`; the same one when asked again. Throws std::runtime_error
  /// naming the fault: a name that leaves the folders, no such file, not a tree.
  [[nodiscard]] std::shared_ptr<const MeasuredTree> tree(const std::string& name);

  /// Notes a mesh, which only clients read; throws as tree() does.
  void note_mesh(const std::string& name);

  /// All that was asked for, in the order of first asking.
  [[nodiscard]] const std::vector<SceneAsset>& assets() const noexcept { return assets_; }

 private:
  [[nodiscard]] std::vector<std::uint8_t> read(const std::string& name) const;
  [[nodiscard]] std::string folder_names() const;
  void note(const std::string& name, const std::vector<std::uint8_t>& bytes);

  std::vector<std::filesystem::path> folders_;
  BroughtFiles brought_;
  std::vector<SceneAsset> assets_;
  std::map<std::string, std::shared_ptr<const MeasuredTree>> trees_;
};

}  // namespace hapticd
