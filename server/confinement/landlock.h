// What of the file system the process may still reach. It holds for all threads that are made
// afterwards, and for good. Not RT.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace hapticd {

/// A file, or a folder with all below it.
struct ReachedPath {
  std::filesystem::path path;
  bool writes = false;  ///< else it is only read
};

/// Leaves the calling thread, and those that it makes, nothing of the file system but `paths`; one
/// that is not there is left out. Nothing can be run. Needs no_new_privs. Returns why it could not
/// be done, for people; empty: it is. May throw std::bad_alloc.
[[nodiscard]] std::string reach_only(std::span<const ReachedPath> paths);

/// The sentence to put behind an `error` with the system's reason in it, where reach_only() may be
/// the reason; else empty. May throw std::bad_alloc.
[[nodiscard]] std::string reach_remedy(std::string_view error);

}  // namespace hapticd
