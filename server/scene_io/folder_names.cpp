// See folder_names.h.
#include "server/scene_io/folder_names.h"

#include <dirent.h>

#include <memory>
#include <string_view>

namespace hapticd {
namespace {

struct Close {
  void operator()(DIR* folder) const noexcept { closedir(folder); }
};

}  // namespace

std::vector<std::string> folder_names(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  const std::unique_ptr<DIR, Close> open(opendir(folder.c_str()));
  if (open == nullptr) return names;
  // NOLINTNEXTLINE(concurrency-mt-unsafe): unsafe for two threads with the same DIR alone
  while (const dirent* entry = readdir(open.get())) {
    const std::string_view name(entry->d_name);
    if (name != "." && name != "..") names.emplace_back(name);
  }
  return names;
}

}  // namespace hapticd
