// See recording.h.
#include "clients/library/recording.h"

namespace hapticd::client {

Recording::Recording(const std::filesystem::path& file) : reader_(file.string()) {
  RecordedMessage message;
  while (reader_.next(message)) messages_.push_back(message);
}

}  // namespace hapticd::client
