// Reads a recording (MCAP, as hapticd writes it) message by message, for clients that show or sound
// it: which message, when, and its bytes. Also one that a killed daemon left, up to its last whole
// record. Bytes are not trusted: lengths are checked. What cannot be read, such as compressed
// chunks, is left out, and whole() says so. To run a session again, hapticd has the full reader.
// Not RT.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "hapticd/v1/recording.pb.h"

namespace hapticd::client {

/// What a message is, by its topic: RecordHeader, SceneRecord, ... of recording.proto.
enum class RecordKind : std::uint8_t { kHeader, kScene, kParameters, kTick, kEvent, kSnapshot };

/// A message; `data` lives as long as the Recording.
struct RecordedMessage {
  RecordKind kind = RecordKind::kHeader;
  std::uint64_t time_ns = 0;  ///< since 1970, by the daemon's clock
  std::string_view data;
};

/// A recording in memory, as a list of its messages in the order of the file.
class Recording {
 public:
  /// Throws std::runtime_error, with the file and the remedy, when it cannot be read, is no
  /// recording of hapticd, or one of a later format. Takes 32 bytes a message, and about 1 s per
  /// GB.
  explicit Recording(const std::filesystem::path& file);
  ~Recording();
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  [[nodiscard]] const v1::RecordHeader& header() const noexcept { return header_; }
  /// Nothing is missing: no record was cut off, damaged or compressed.
  [[nodiscard]] bool whole() const noexcept { return ended_ && !unreadable_; }
  [[nodiscard]] std::size_t size() const noexcept { return messages_.size(); }
  [[nodiscard]] const RecordedMessage& operator[](std::size_t i) const { return messages_[i]; }

 private:
  void index(std::string_view records);
  void take(unsigned opcode, std::string_view content);
  void take_channel(std::string_view content);
  void take_message(std::string_view content);

  std::string_view bytes_;  ///< mapped
  std::map<std::uint16_t, RecordKind> channels_;
  std::vector<RecordedMessage> messages_;
  v1::RecordHeader header_;
  bool ended_ = false;       ///< the end of the data was met
  bool unreadable_ = false;  ///< something before it was left out
};

}  // namespace hapticd::client
