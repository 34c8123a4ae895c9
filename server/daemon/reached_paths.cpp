// See reached_paths.h.
#include "server/daemon/reached_paths.h"

#include <string>
#include <string_view>
#include <system_error>

#include "server/recorder/recorder_thread.h"
#include "server/scene_io/folder_names.h"
#include "server/scene_io/model_files.h"

namespace hapticd {
namespace {

namespace fs = std::filesystem;

/// Libraries, time zones, udev, avahi and what the kernel tells.
constexpr std::string_view kSystem[] = {"/usr",
                                        "/lib",
                                        "/lib64",
                                        "/proc",
                                        "/sys",
                                        "/run",
                                        "/etc/udev",
                                        "/etc/localtime",
                                        "/etc/ld.so.cache",
                                        "/etc/avahi",
                                        "/etc/nsswitch.conf",
                                        "/etc/passwd",
                                        "/etc/group",
                                        "/etc/machine-id",
                                        "/dev"};

/// The nearest folder above `path` that is there; "/" is too much.
fs::path folder_that_is(const fs::path& path) {
  std::error_code ignored;
  fs::path folder = fs::absolute(path, ignored);
  while (folder.has_relative_path() && !fs::is_directory(folder, ignored)) {
    folder = folder.parent_path();
  }
  return folder.has_relative_path() ? folder : fs::path();
}

/// The folder of a file that an option names; names of what is installed have none.
void add_folder_of(const std::string& file, std::vector<ReachedPath>& paths) {
  std::error_code ignored;
  if (!file.empty() && fs::exists(file, ignored)) {
    paths.push_back({fs::absolute(file, ignored).parent_path(), false});
    paths.push_back({file, false});  // it may be a link
  }
}

/// A folder, which may be a link, and what links in it lead to.
void add_linked(const ReachedPath& folder, std::vector<ReachedPath>& paths) {
  paths.push_back(folder);
  std::error_code ignored;
  for (const std::string& name : folder_names(folder.path)) {
    const fs::path path = folder.path / name;
    if (fs::is_symlink(path, ignored)) paths.push_back({path, folder.writes});
  }
}

}  // namespace

std::vector<ReachedPath> reached_paths(const DaemonOptions& options) {
  std::vector<ReachedPath> paths;
  for (const std::string_view path : kSystem) paths.push_back({path, path == "/dev"});
  for (const fs::path& scenes : installed_paths().scenes) {
    const fs::path data = scenes.parent_path();
    paths.push_back({data, false});
    for (const std::string& name : folder_names(data)) add_linked({data / name, false}, paths);
  }
  const v1::Config& config = options.config;
  for (const std::string* file :
       {&options.config_file, &config.scene(), &config.gesture(), &config.stop_key()}) {
    add_folder_of(*file, paths);
  }
  for (const v1::DeviceChoice& device : config.device()) {
    add_folder_of(device.profile(), paths);
    const std::size_t colon = device.source().find(':');
    if (colon != std::string::npos) add_folder_of(device.source().substr(colon + 1), paths);
  }
  if (!config.keys().empty()) paths.push_back({config.keys(), false});
  if (!config.record().empty()) paths.push_back({folder_that_is(fs::path(config.record())), true});
  const fs::path state = recordings_folder().parent_path();
  std::error_code ignored;
  fs::create_directories(state, ignored);
  add_linked({state, true}, paths);
  return paths;
}

}  // namespace hapticd
