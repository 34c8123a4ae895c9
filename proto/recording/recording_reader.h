// Reads a recording of ours, message by message, from the front to the back, also one that a killed
// daemon left. Not RT.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "hapticd/v1/recording.pb.h"
#include "proto/recording/mapped_file.h"
#include "proto/recording/mcap_reader.h"
#include "proto/recording/recording_format.h"

namespace hapticd {

/// A message; `data` is valid as long as the reader.
struct RecordedMessage {
  RecordKind kind = RecordKind::kHeader;
  std::uint64_t time_ns = 0;  ///< since 1970
  std::string_view data;
};

/// What a whole recording has.
struct RecordingSummary {
  std::uint64_t ticks = 0;
  std::uint64_t last_tick = 0;  ///< of the last scene
  bool complete = false;        ///< closed in order
  std::string end;              ///< how it ends, for people
};

/// The file is none of ours, or cannot be read; the text names it, and the remedy.
class RecordingError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class RecordingReader {
 public:
  /// Reads the header of the file `path`, as find_recording() has it. Throws RecordingError, also
  /// for a recording of another format.
  explicit RecordingReader(const std::string& path);

  /// The next message after the header; false at the end.
  bool next(RecordedMessage& message);
  /// Starts again after the header.
  void rewind();
  /// How the reading ended, once next() has given false.
  [[nodiscard]] std::string describe_end() const { return reader_->describe_end(); }
  [[nodiscard]] bool complete() const noexcept { return reader_->end() == McapEnd::kComplete; }

  [[nodiscard]] const v1::RecordHeader& header() const noexcept { return header_; }
  [[nodiscard]] const std::string& path() const noexcept { return path_; }

 private:
  std::string path_;
  MappedFile file_;
  std::optional<McapReader> reader_;
  v1::RecordHeader header_;
};

/// Looks through the whole file of `reader`, which starts again afterwards. About 1 s per GB.
[[nodiscard]] RecordingSummary summarise(RecordingReader& reader);

}  // namespace hapticd
