// See default_recordings.h.
#include "proto/recording/default_recordings.h"

#include <cstdlib>

namespace hapticd {

std::filesystem::path default_recordings() {
  // NOLINTBEGIN(concurrency-mt-unsafe): nobody changes the environment
  if (const char* state = std::getenv("XDG_STATE_HOME"); state != nullptr && *state != '\0') {
    return std::filesystem::path(state) / "hapticd" / "recordings";
  }
  const char* home = std::getenv("HOME");
  // NOLINTEND(concurrency-mt-unsafe)
  return std::filesystem::path(home != nullptr && *home != '\0' ? home : "/tmp") /
         ".local/state/hapticd/recordings";
}

std::string find_recording(const std::string& name) {
  std::error_code error;
  if (name.empty() || name.find('/') != std::string::npos) return name;
  if (std::filesystem::exists(name, error)) return name;
  const std::filesystem::path listed = default_recordings() / name;
  return std::filesystem::is_regular_file(listed, error) ? listed.string() : name;
}

}  // namespace hapticd
