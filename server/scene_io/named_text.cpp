// See named_text.h.
#include "server/scene_io/named_text.h"

#include <google/protobuf/stubs/common.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <system_error>

#include "proto/hints/nearest_name.h"
#include "server/scene_io/model_files.h"

namespace hapticd {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kExtension = ".textproto";

bool is_file(const std::string& source) {
  return source.find('/') != std::string::npos || source.ends_with(kExtension);
}

/// Whether a file of a folder is listed: it can be read by its name, and the name can be sent.
bool can_be_listed(const fs::directory_entry& entry) {
  std::error_code ignored;
  if (entry.path().extension() != kExtension || !entry.is_regular_file(ignored)) return false;
  const std::string name = entry.path().stem().string();
  return fault_of_name(name).empty() && google::protobuf::internal::IsStructurallyValidUTF8(name);
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
  if (name.size() > kMaxInstalledName) {
    return "has " + std::to_string(name.size()) + " bytes, more than " +
           std::to_string(kMaxInstalledName);
  }
  if (name.find('/') != std::string_view::npos) return "has '/' in it";
  if (name.front() == '.') return "begins with '.'";
  const bool control = std::any_of(name.begin(), name.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20U || c == '\x7f';
  });
  return control ? "has control characters in it" : "";
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
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
      if (can_be_listed(entry)) names.insert(entry.path().stem().string());
    }
  }
  return {names.begin(), names.end()};
}

NamedText read_installed(const std::string& name, const std::vector<fs::path>& folders,
                         std::string_view what, std::uintmax_t longest) {
  // What cannot be a name is not repeated: it may be long, or full of escape sequences.
  if (const std::string fault = fault_of_name(name); !fault.empty()) {
    return refused("the " + std::string(what) + " asked for", "its name " + fault,
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
  return is_file(source) ? read_text(source, longest)
                         : read_installed(source, folders, what, longest);
}

}  // namespace hapticd
