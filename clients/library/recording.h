// A recording (MCAP, as hapticd writes it) as a list of its messages, for clients that show or
// sound it: which message, when, and its bytes. Also one that a killed daemon left, up to its last
// whole record; whole() says whether that is all. To run a session again is for hapticd. Not RT.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "proto/recording/recording_reader.h"

namespace hapticd::client {

class Recording {
 public:
  /// Throws RecordingError, with the file and the remedy, when it cannot be read, is no recording
  /// of hapticd, or one of another format. Takes 32 bytes a message, and about 1 s per GB.
  explicit Recording(const std::filesystem::path& file);

  [[nodiscard]] const v1::RecordHeader& header() const noexcept { return reader_.header(); }
  /// Nothing is missing: the file was closed in order, and no record is damaged or compressed.
  [[nodiscard]] bool whole() const noexcept { return reader_.complete(); }
  /// Messages after the header, in the order of the file; their data lives as long as this.
  [[nodiscard]] std::size_t size() const noexcept { return messages_.size(); }
  [[nodiscard]] const RecordedMessage& operator[](std::size_t i) const { return messages_[i]; }

 private:
  RecordingReader reader_;
  std::vector<RecordedMessage> messages_;
};

}  // namespace hapticd::client
