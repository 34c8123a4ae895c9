// See recorded_events.h. The layout of the file is the specification of MCAP, version 0 (mcap.dev).
#include "clients/audio/recorded_events.h"

#include <cerrno>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace hapticd::audio {
namespace {

constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};
/// Kinds of record.
constexpr std::uint64_t kSchema = 3;
constexpr std::uint64_t kChannel = 4;
constexpr std::uint64_t kMessage = 5;
constexpr std::uint64_t kChunk = 6;
constexpr std::uint64_t kDataEnd = 15;

/// Takes from the front of bytes; once something is missing all further is empty.
struct Cursor {
  std::string_view rest{};
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
  std::string records(std::string_view bytes) {
    Cursor file{bytes};
    while (!chunk_.rest.empty() || !file.rest.empty()) {
      const bool inside_chunk = !chunk_.rest.empty();
      Cursor& cursor = inside_chunk ? chunk_ : file;
      const std::uint64_t opcode = cursor.number(1);
      const std::string_view content = cursor.bytes(cursor.number(8));
      if (cursor.failed) return inside_chunk ? "a chunk is broken" : "it ends early";
      if (opcode == kDataEnd) return {};
      const std::string problem =
          opcode == kChunk && !inside_chunk ? chunk({content}) : record(opcode, {content});
      if (!problem.empty()) return problem;
    }
    return "it ends early";
  }

 private:
  std::string chunk(Cursor cursor) {
    cursor.bytes(8 + 8 + 8 + 4);
    if (!cursor.text().empty()) return "it is compressed, which hapticd's own are not";
    chunk_ = {cursor.bytes(cursor.number(8))};
    return cursor.failed ? "a chunk is broken" : "";
  }

  std::string record(std::uint64_t opcode, Cursor cursor) {
    if (opcode == kMessage) return message(cursor);
    if (opcode == kSchema) {
      const std::uint64_t id = cursor.number(2);
      schemas_[id] = cursor.text();
    } else if (opcode == kChannel) {
      const std::uint64_t id = cursor.number(2);
      channels_[id] = schemas_[cursor.number(2)];
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
  Cursor chunk_;                                   ///< what is left of the present one
  std::map<std::uint64_t, std::string> schemas_;   ///< names of types, by id
  std::map<std::uint64_t, std::string> channels_;  ///< the same, by channel
};

}  // namespace

std::string read_recording(std::string_view bytes, const RecordingHandlers& handlers) {
  if (!bytes.starts_with(kMagic)) return "it is no recording";
  return Reader(handlers).records(bytes.substr(kMagic.size()));
}

std::string file_content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream content;
  if (!file || !(content << file.rdbuf())) {
    throw std::runtime_error(path + ": " + std::generic_category().message(errno));
  }
  return std::move(content).str();
}

}  // namespace hapticd::audio
