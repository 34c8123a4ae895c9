// What is in a folder. Not RT.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace hapticd {

/// Names of all that is in `folder`, but "." and "..", in no order; none where it cannot be read.
/// In place of std::filesystem::directory_iterator, which ends the program where memory is short:
/// that of libstdc++ 12 asks for it in a function that may not throw. Throws std::bad_alloc.
[[nodiscard]] std::vector<std::string> folder_names(const std::filesystem::path& folder);

}  // namespace hapticd
