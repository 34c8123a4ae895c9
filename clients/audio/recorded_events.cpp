// See recorded_events.h. The layout of the file is the specification of MCAP, version 0 (mcap.dev).
#include "clients/audio/recorded_events.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

namespace hapticd::audio {
namespace {

constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};
enum Opcode : std::uint8_t { kSchema = 3, kChannel = 4, kMessage = 5, kChunk = 6, kDataEnd = 15 };

/// Takes from the front of bytes; once something is missing all further is empty.
struct Cursor {
  std::string_view rest;
  bool failed = false;

  std::string_view bytes(std::uint64_t count) {
    if (failed || count > rest.size()) {
      failed = true;
      return {};
    }
    const std::string_view taken = rest.substr(0, static_cast<std::size_t>(count));
    rest.remove_prefix(taken.size());
    return taken;
  }
  std::uint64_t number(std::size_t size) {
    const std::string_view taken = bytes(size);
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < taken.size(); ++i) {
      value |= static_cast<std::uint64_t>(static_cast<unsigned char>(taken[i])) << (8 * i);
    }
    return value;
  }
  std::string_view text() { return bytes(number(4)); }
};

class Reader {
 public:
  explicit Reader(const RecordingHandlers& handlers) : handlers_(handlers) {}

  /// Records until the end of the data; what is wrong.
  std::string records(std::string_view bytes, bool inside_chunk) {
    Cursor cursor{bytes};
    while (!cursor.rest.empty()) {
      const auto opcode = static_cast<Opcode>(cursor.number(1));
      const std::string_view content = cursor.bytes(cursor.number(8));
      if (cursor.failed) return inside_chunk ? "a chunk is broken" : "it ends early";
      if (opcode == kDataEnd) return {};
      const std::string problem = record(opcode, content, inside_chunk);
      if (!problem.empty()) return problem;
    }
    return inside_chunk ? "" : "it ends early";
  }

 private:
  std::string record(Opcode opcode, std::string_view content, bool inside_chunk) {
    Cursor cursor{content};
    if (opcode == kSchema) {
      const std::uint64_t id = cursor.number(2);
      schemas_[id] = cursor.text();
    } else if (opcode == kChannel) {
      const std::uint64_t id = cursor.number(2);
      channels_[id] = schemas_[cursor.number(2)];
    } else if (opcode == kMessage) {
      return message(cursor);
    } else if (opcode == kChunk && !inside_chunk) {
      cursor.bytes(8 + 8 + 8 + 4);
      if (!cursor.text().empty()) return "it is compressed, which hapticd's own are not";
      return records(cursor.bytes(cursor.number(8)), true);
    }
    return cursor.failed ? "a record is broken" : "";
  }

  std::string message(Cursor cursor) {
    const std::string& type = channels_[cursor.number(2)];
    cursor.bytes(4 + 8 + 8);
    if (cursor.failed) return "a message is broken";
    const auto size = static_cast<int>(cursor.rest.size());
    if (type == "hapticd.v1.SceneRecord") {
      v1::SceneRecord scene;
      if (!scene.ParseFromArray(cursor.rest.data(), size)) return "a scene is broken";
      handlers_.scene(scene);
    } else if (type == "hapticd.v1.EventRecord") {
      v1::EventRecord event;
      if (!event.ParseFromArray(cursor.rest.data(), size)) return "an event is broken";
      handlers_.event(event);
    }
    return {};
  }

  const RecordingHandlers& handlers_;
  std::map<std::uint64_t, std::string> schemas_;   ///< names of types, by id
  std::map<std::uint64_t, std::string> channels_;  ///< the same, by channel
};

}  // namespace

std::string read_recording(std::string_view bytes, const RecordingHandlers& handlers) {
  if (!bytes.starts_with(kMagic)) return "it is no recording";
  return Reader(handlers).records(bytes.substr(kMagic.size()), false);
}

std::string file_content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream content;
  if (!file || !(content << file.rdbuf())) {
    throw std::runtime_error(path + ": " + std::strerror(errno));
  }
  return std::move(content).str();
}

}  // namespace hapticd::audio
