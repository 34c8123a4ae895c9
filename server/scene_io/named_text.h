// Texts that people name: of an installed file, by its name without folder and ending, or of any
// file by its path. Offline.
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

/// Names of the .textproto files in `folders`, in alphabetical order.
[[nodiscard]] std::vector<std::string> list_names(
    const std::vector<std::filesystem::path>& folders);

/// The text of `source`: a file where it has '/' or ".textproto" in it, else looked for in
/// `folders`. `what` says in problems what is wanted: "scene". Longer than `longest` bytes:
/// refused.
[[nodiscard]] NamedText read_named(const std::string& source,
                                   const std::vector<std::filesystem::path>& folders,
                                   std::string_view what, std::uintmax_t longest);

}  // namespace hapticd
