// A recording written after the specification of MCAP (mcap.dev), by code that shares nothing with
// the recorder nor the reader: what playback is tested on.
#pragma once

#include <cstdint>
#include <fstream>
#include <string>

#include "hapticd/v1/recording.pb.h"

namespace hapticd::test {

/// Little-endian `value` in `bytes` bytes, 8 at most.
inline std::string little(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xff);
  return text;
}

inline std::string prefixed(const std::string& text) { return little(text.size(), 4) + text; }

inline std::string record(int opcode, const std::string& content) {
  return little(static_cast<std::uint64_t>(opcode), 1) + little(content.size(), 8) + content;
}

/// Collects messages, in chunks or without.
class SampleRecording {
 public:
  SampleRecording() {
    const char* const topics[] = {"header", "scene", "parameters", "tick", "event", "snapshot"};
    for (std::uint64_t id = 1; id <= 6; ++id) {
      records_ += record(4, little(id, 2) + little(0, 2) +
                                prefixed(std::string("/hapticd/") + topics[id - 1]) +
                                prefixed("protobuf") + little(0, 4));
    }
  }
  /// Channel 1 to 6 as the topics above.
  void message(std::uint64_t channel, std::uint64_t time_ns, const std::string& data) {
    records_ += record(
        5, little(channel, 2) + little(0, 4) + little(time_ns, 8) + little(time_ns, 8) + data);
  }
  /// What came so far becomes a chunk, compressed with `compression` as it says.
  void close_chunk(const std::string& compression = "") {
    file_ += record(6, little(0, 8) + little(0, 8) + little(records_.size(), 8) + little(0, 4) +
                           prefixed(compression) + little(records_.size(), 8) + records_);
    records_.clear();
  }
  [[nodiscard]] std::string bytes(bool finished = true) const {
    const std::string magic("\x89MCAP0\r\n", 8);
    std::string all = magic + record(1, prefixed("") + prefixed("test")) + file_ + records_;
    if (finished) all += record(15, little(0, 4)) + record(2, std::string(20, '\0')) + magic;
    return all;
  }
  void save(const std::string& path, bool finished = true) const {
    std::ofstream(path, std::ios::binary) << bytes(finished);
  }

 private:
  std::string file_;
  std::string records_;
};

}  // namespace hapticd::test
