// See recording.h.
#include "clients/library/recording.h"

#include <cstdlib>

namespace hapticd::client {

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

Recording::Recording(const std::filesystem::path& file) : reader_(file.string()) {
  RecordedMessage message;
  while (reader_.next(message)) messages_.push_back(message);
}

}  // namespace hapticd::client
