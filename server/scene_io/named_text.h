// Texts that people name: an installed file by its name without folder and ending, or any file by
// its path. Over the network only installed ones can be named. Offline.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/scene_io/scene_problem.h"

namespace hapticd {

/// What was found.
struct NamedText {
  std::string text;
  std::filesystem::path path;
  std::optional<SceneProblem> problem;  ///< there is no text
};

/// Longest name of an installed file, bytes.
inline constexpr std::size_t kMaxInstalledName = 64;

/// Why no installed file can have this name, in words that follow "its name"; empty: one can. A
/// name is 1 to 64 of a-z 0-9 _ -.
[[nodiscard]] std::string fault_of_name(std::string_view name);

/// The file of an installed name, in the first of `folders` that has it; empty: there is none, or
/// no file can have the name.
[[nodiscard]] std::filesystem::path installed_file(
    const std::string& name, const std::vector<std::filesystem::path>& folders);

/// Names of the .textproto files in `folders`, in alphabetical order: those that installed_file()
/// finds.
[[nodiscard]] std::vector<std::string> list_names(
    const std::vector<std::filesystem::path>& folders);

/// The text of the installed file `name`, from `folders` and nowhere else. `what` says in problems
/// what is wanted: "scene". Longer than `longest` bytes: refused.
[[nodiscard]] NamedText read_installed(const std::string& name,
                                       const std::vector<std::filesystem::path>& folders,
                                       std::string_view what, std::uintmax_t longest);

/// The same; but where `source` has '/' or ".textproto" in it, the text of that file, wherever it
/// is: for the owner of the machine, not for peers.
[[nodiscard]] NamedText read_named(const std::string& source,
                                   const std::vector<std::filesystem::path>& folders,
                                   std::string_view what, std::uintmax_t longest);

}  // namespace hapticd
