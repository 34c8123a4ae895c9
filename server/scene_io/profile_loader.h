// Loads a device profile from a name, a file or a message: parsed, checked against the comments of
// device_profile.proto, and translated for the drivers; or refused with every fault in it. Offline.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "device/api/device_sheet.h"
#include "hapticd/v1/device_profile.pb.h"
#include "server/scene_io/scene_problem.h"

namespace hapticd {

/// Folders with profiles.
using ProfileFolders = std::vector<std::filesystem::path>;

/// The folder `devices` of the installation (installed_paths of model_files.h says where that is).
[[nodiscard]] ProfileFolders installed_profiles();

struct ProfileResult {
  std::optional<DeviceSheet> loaded;  ///< none when there is a fault
  SceneProblems problems;
};

/// All profiles of the installation that load.
[[nodiscard]] std::vector<DeviceSheet> load_installed_profiles();

/// `source` is the name of an installed profile, or a file: with '/' or ".textproto" in it.
[[nodiscard]] ProfileResult load_profile(const std::string& source, const ProfileFolders& folders);

/// From a message, such as that of a recording; problems have the paths of its fields, and no file
/// or line.
[[nodiscard]] ProfileResult check_profile(const v1::DeviceProfile& profile);

}  // namespace hapticd
