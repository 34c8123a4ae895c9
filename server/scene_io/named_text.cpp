// See named_text.h.
#include "server/scene_io/named_text.h"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <system_error>

#include "proto/hints/nearest_name.h"
#include "server/scene_io/folder_names.h"
#include "server/scene_io/model_files.h"

namespace hapticd {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kExtension = ".textproto";

bool is_file(const std::string& source) {
  return source.find('/') != std::string::npos || source.ends_with(kExtension);
}

/// Whether a file of a folder is listed: it can be read by its name, and the name can be sent.
bool can_be_listed(const fs::path& path) {
  std::error_code ignored;
  if (path.extension() != kExtension || !fs::is_regular_file(path, ignored)) return false;
  return fault_of_name(path.stem().string()).empty();
}

/// Which ones there are, and which of them may have been meant.
std::string known(const std::string& name, const std::vector<fs::path>& folders,
                  std::string_view what) {
  const std::vector<std::string> names = list_names(folders);
  if (names.empty()) return "No " + std::string(what) + " is installed.";
  std::string text;
  for (const std::string& each : names) text += (text.empty() ? "" : ", ") + each;
  // The hint first: the daemon cuts what is long.
  const std::string hint = hints::did_you_mean(name, names);
  return (hint.empty() ? "" : hint.substr(1) + " ") + "Installed are " + text + ".";
}

NamedText refused(const std::string& file, std::string message, std::string remedy) {
  return NamedText{"", "",
                   SceneProblem{false, file, 0, 0, "", std::move(message), std::move(remedy)}};
}

/// What cannot be a name is not repeated: it may be long, or full of escape sequences.
NamedText no_name(const std::string& name, std::string_view what, std::string remedy) {
  return refused("the " + std::string(what) + " asked for", "its name " + fault_of_name(name),
                 std::move(remedy));
}

NamedText read_text(const fs::path& path, std::uintmax_t longest) {
  try {
    const std::vector<std::uint8_t> bytes = read_file(path, longest);
    return {{bytes.begin(), bytes.end()}, path, std::nullopt};
  } catch (const std::runtime_error& fault) {
    return refused(path.string(), std::string("it ") + fault.what(), "");
  }
}

}  // namespace

std::string fault_of_name(std::string_view name) {
  if (name.empty()) return "is empty";
  const bool plain = std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
  if (!plain) return "has other characters than a-z 0-9 _ -";
  if (name.size() > kMaxInstalledName) {
    return "has " + std::to_string(name.size()) + " bytes, more than " +
           std::to_string(kMaxInstalledName);
  }
  return "";
}

fs::path installed_file(const std::string& name, const std::vector<fs::path>& folders) {
  if (!fault_of_name(name).empty()) return {};
  for (const fs::path& folder : folders) {
    std::error_code ignored;
    fs::path path = folder / (name + std::string(kExtension));
    if (fs::is_regular_file(path, ignored)) return path;
  }
  return {};
}

std::vector<std::string> list_names(const std::vector<fs::path>& folders) {
  std::set<std::string> names;
  for (const fs::path& folder : folders) {
    for (const std::string& name : folder_names(folder)) {
      const fs::path path = folder / name;
      if (can_be_listed(path)) names.insert(path.stem().string());
    }
  }
  return {names.begin(), names.end()};
}

NamedText read_installed(const std::string& name, const std::vector<fs::path>& folders,
                         std::string_view what, std::uintmax_t longest) {
  if (!fault_of_name(name).empty()) {
    return no_name(name, what,
                   "Name an installed " + std::string(what) + ", or send what is in the file.");
  }
  const fs::path path = installed_file(name, folders);
  if (path.empty()) {
    return refused(name, "there is no " + std::string(what) + " of this name",
                   known(name, folders, what));
  }
  return read_text(path, longest);
}

NamedText read_named(const std::string& source, const std::vector<fs::path>& folders,
                     std::string_view what, std::uintmax_t longest) {
  if (is_file(source)) return read_text(source, longest);
  if (!fault_of_name(source).empty()) {
    return no_name(source, what, "Give the file's path, with a '/' in it.");
  }
  return read_installed(source, folders, what, longest);
}

}  // namespace hapticd
