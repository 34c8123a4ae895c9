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

std::filesystem::path service_recordings() { return "/var/lib/hapticd/recordings"; }

std::string find_recording(const std::string& name) {
  std::error_code error;
  if (name.empty() || name.find('/') != std::string::npos) return name;
  for (const std::string& named : {name, name + ".mcap"}) {
    if (std::filesystem::exists(named, error)) return named;
    for (const std::filesystem::path& folder : {default_recordings(), service_recordings()}) {
      const std::filesystem::path listed = folder / named;
      if (std::filesystem::is_regular_file(listed, error)) return listed.string();
    }
  }
  return name;
}

}  // namespace hapticd
