// The files of the page: those below one folder, by the path of an address. Not RT.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace hapticd::web {

/// A file to be sent.
struct PageFile {
  std::string type;  ///< of its content, for the browser
  std::string bytes;
  bool lasting = false;  ///< its name changes with its content, so it may be kept for ever
};

/// The file at `target` (the path of a request, / and all) below `folder`; / is index.html. Nothing
/// when there is none, or the path leads out of the folder, or to a name that begins with a dot.
[[nodiscard]] std::optional<PageFile> page_file(const std::filesystem::path& folder,
                                                std::string_view target);

/// Type of content by the end of a name.
[[nodiscard]] std::string content_type(const std::filesystem::path& name);

}  // namespace hapticd::web
