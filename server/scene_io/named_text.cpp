// See named_text.h.
#include "server/scene_io/named_text.h"

#include <set>
#include <stdexcept>
#include <system_error>

#include "server/scene_io/model_files.h"

namespace hapticd {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kExtension = ".textproto";

bool is_file(const std::string& source) {
  return source.find('/') != std::string::npos || source.ends_with(kExtension);
}

/// The installed file of a name; empty when there is none.
fs::path find_installed(const std::string& name, const std::vector<fs::path>& folders) {
  for (const fs::path& folder : folders) {
    std::error_code ignored;
    fs::path path = folder / (name + std::string(kExtension));
    if (fs::is_regular_file(path, ignored)) return path;
  }
  return {};
}

std::string known(const std::vector<fs::path>& folders, std::string_view what) {
  std::string text;
  for (const std::string& name : list_names(folders)) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "No " + std::string(what) + " is installed."
                      : "Installed are " + text + ".";
}

}  // namespace

std::vector<std::string> list_names(const std::vector<fs::path>& folders) {
  std::set<std::string> names;
  for (const fs::path& folder : folders) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
      if (entry.path().extension() == kExtension) names.insert(entry.path().stem().string());
    }
  }
  return {names.begin(), names.end()};
}

NamedText read_named(const std::string& source, const std::vector<fs::path>& folders,
                     std::string_view what, std::uintmax_t longest) {
  const auto refused = [](const std::string& file, std::string message, std::string remedy) {
    return NamedText{"", "",
                     SceneProblem{false, file, 0, 0, "", std::move(message), std::move(remedy)}};
  };
  const fs::path path = is_file(source) ? fs::path(source) : find_installed(source, folders);
  if (path.empty()) {
    return refused(source, "there is no " + std::string(what) + " of this name",
                   known(folders, what));
  }
  try {
    const std::vector<std::uint8_t> bytes = read_file(path, longest);
    return {{bytes.begin(), bytes.end()}, path, std::nullopt};
  } catch (const std::runtime_error& fault) {
    return refused(path.string(), std::string("it ") + fault.what(), "");
  }
}

}  // namespace hapticd
