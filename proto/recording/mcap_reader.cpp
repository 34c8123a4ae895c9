// See mcap_reader.h.
#include "proto/recording/mcap_reader.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "proto/recording/mapped_file.h"

namespace hapticd {
namespace {

/// Ids of schemas and channels there can be.
constexpr std::size_t kIds = 1U << 16U;

/// True when every channel with a message in the last chunk has an index for it.
bool last_chunk_indexed(std::string_view bytes, const McapLayout& layout) {
  if (layout.chunks.empty()) return true;
  const McapChunk& chunk = layout.chunks.back();
  McapCursor content(bytes.substr(chunk.offset + kMcapPrefix, chunk.length - kMcapPrefix));
  // Two times, size, CRC, compression (none) and length come before the records.
  (void)content.bytes(8 + 8 + 8 + 4 + 4 + 8);
  while (content.left() > 0 && !content.failed()) {
    const auto opcode = static_cast<McapOpcode>(content.number<std::uint8_t>());
    McapCursor record(content.bytes(content.number<std::uint64_t>()));
    if (opcode == McapOpcode::kMessage &&
        chunk.index_offsets.count(record.number<std::uint16_t>()) == 0) {
      return false;
    }
  }
  return true;
}

/// Cuts `path` to `length` bytes and appends `tail`.
bool rewrite_end(const std::string& path, std::uint64_t length, std::string_view tail,
                 std::string& error) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  bool good = file >= 0 && ::ftruncate(file, static_cast<off_t>(length)) == 0 &&
              ::lseek(file, 0, SEEK_END) >= 0;
  while (good && !tail.empty()) {
    const ssize_t written = ::write(file, tail.data(), tail.size());
    if (written < 0 && errno == EINTR) continue;
    good = written > 0;
    if (good) tail.remove_prefix(static_cast<std::size_t>(written));
  }
  if (!good) error = path + ": " + std::generic_category().message(errno);
  if (file >= 0) ::close(file);
  return good;
}

}  // namespace

McapReader::McapReader(std::string_view bytes)
    : bytes_(bytes), known_schemas_(kIds), known_channels_(kIds) {
  if (bytes_.substr(0, kMcapMagic.size()) == kMcapMagic) {
    place_ = whole_ = kMcapMagic.size();
  } else {
    stop(kMcapMagic.substr(0, bytes_.size()) == bytes_ ? McapEnd::kTruncated : McapEnd::kBroken);
  }
}

void McapReader::stop(McapEnd end) noexcept {
  end_ = end;
  if (end == McapEnd::kBroken && whole_ > record_) {
    // What is broken may be inside of the last record: then that is not whole.
    whole_ = record_;
    if (!layout_.chunks.empty() && layout_.chunks.back().offset >= whole_)
      layout_.chunks.pop_back();
  }
  chunk_ = {};
  has_message_ = false;
}

bool McapReader::next(McapMessage& message) {
  for (;;) {
    if (!chunk_.empty()) {
      McapCursor cursor(chunk_);
      const auto opcode = static_cast<McapOpcode>(cursor.number<std::uint8_t>());
      const std::string_view content = cursor.bytes(cursor.number<std::uint64_t>());
      if (cursor.failed()) {
        stop(McapEnd::kBroken);
        return false;
      }
      chunk_.remove_prefix(chunk_.size() - cursor.left());
      if (opcode == McapOpcode::kSchema) take_schema(content);
      if (opcode == McapOpcode::kChannel) take_channel(content);
      if (opcode == McapOpcode::kMessage) return take_message(content, message);
      if (end_ != McapEnd::kMore) return false;
    } else if (has_message_) {
      has_message_ = false;
      return take_message(message_, message);
    } else if (!next_record()) {
      return false;
    }
  }
}

bool McapReader::next_record() {
  if (end_ != McapEnd::kMore) return false;
  const std::uint64_t offset = record_ = place_;
  McapCursor cursor(bytes_.substr(offset));
  const auto opcode = static_cast<McapOpcode>(cursor.number<std::uint8_t>());
  const std::string_view content = cursor.bytes(cursor.number<std::uint64_t>());
  if (cursor.failed()) {
    stop(McapEnd::kTruncated);
    return false;
  }
  place_ = bytes_.size() - cursor.left();
  if (opcode == McapOpcode::kDataEnd) {
    // What follows repeats what was read; all that matters is whether it is there.
    const std::string_view rest = bytes_.substr(place_);
    constexpr std::size_t kFooter = kMcapPrefix + 20;
    const bool complete =
        rest.size() >= kFooter + kMcapMagic.size() &&
        rest.substr(rest.size() - kMcapMagic.size()) == kMcapMagic &&
        rest[rest.size() - kMcapMagic.size() - kFooter] == static_cast<char>(McapOpcode::kFooter);
    stop(complete ? McapEnd::kComplete : McapEnd::kTruncated);
    return false;
  }
  take(opcode, content, offset);
  if (end_ != McapEnd::kMore) return false;
  whole_ = place_;
  return true;
}

void McapReader::take(McapOpcode opcode, std::string_view content, std::uint64_t offset) {
  switch (opcode) {
    case McapOpcode::kSchema:
      take_schema(content);
      break;
    case McapOpcode::kChannel:
      take_channel(content);
      break;
    case McapOpcode::kChunk:
      take_chunk(content, offset);
      break;
    case McapOpcode::kMessageIndex:
      take_index(content, offset);
      break;
    case McapOpcode::kMessage:
      // Where there are chunks messages are in them: this one has no CRC and is a damaged index.
      if (!layout_.chunks.empty()) return stop(McapEnd::kBroken);
      message_ = content;
      has_message_ = true;
      break;
    case McapOpcode::kFooter:
      stop(McapEnd::kBroken);
      break;  // without an end of data
    default:
      // Attachments, metadata and what later versions add are skipped; 0 is not a record.
      if (static_cast<std::uint8_t>(opcode) == 0) stop(McapEnd::kBroken);
  }
}

void McapReader::take_chunk(std::string_view content, std::uint64_t offset) {
  McapCursor cursor(content);
  McapChunk chunk;
  chunk.start_time = cursor.number<std::uint64_t>();
  chunk.end_time = cursor.number<std::uint64_t>();
  chunk.size = cursor.number<std::uint64_t>();
  const auto crc = cursor.number<std::uint32_t>();
  const std::string_view compression = cursor.text();
  const std::string_view records = cursor.bytes(cursor.number<std::uint64_t>());
  if (cursor.failed()) return stop(McapEnd::kBroken);
  if (!compression.empty()) return stop(McapEnd::kForeign);
  // A CRC of 0 says that there is none.
  if (records.size() != chunk.size || (crc != 0 && crc != mcap_crc(records))) {
    return stop(McapEnd::kBroken);
  }
  chunk.offset = offset;
  chunk.length = kMcapPrefix + content.size();
  layout_.chunks.push_back(std::move(chunk));
  chunk_ = records;
}

void McapReader::take_schema(std::string_view content) {
  McapCursor cursor(content);
  McapSchema schema;
  schema.id = cursor.number<std::uint16_t>();
  schema.name = cursor.text();
  schema.encoding = cursor.text();
  schema.data = cursor.text();
  if (cursor.failed() || schema.id == 0) return stop(McapEnd::kBroken);
  if (known_schemas_[schema.id]) return;
  known_schemas_[schema.id] = true;
  layout_.schemas.push_back(std::move(schema));
}

void McapReader::take_channel(std::string_view content) {
  McapCursor cursor(content);
  McapChannel channel;
  channel.id = cursor.number<std::uint16_t>();
  channel.schema_id = cursor.number<std::uint16_t>();
  channel.topic = cursor.text();
  channel.encoding = cursor.text();
  (void)cursor.text();  // metadata
  if (cursor.failed()) return stop(McapEnd::kBroken);
  if (known_channels_[channel.id]) return;
  known_channels_[channel.id] = true;
  layout_.channels.push_back(std::move(channel));
}

void McapReader::take_index(std::string_view content, std::uint64_t offset) {
  McapCursor cursor(content);
  const auto channel = cursor.number<std::uint16_t>();
  if (cursor.failed() || layout_.chunks.empty()) return;
  McapChunk& chunk = layout_.chunks.back();
  chunk.index_offsets[channel] = offset;
  chunk.index_length += kMcapPrefix + content.size();
}

bool McapReader::take_message(std::string_view content, McapMessage& message) {
  McapCursor cursor(content);
  message.channel = cursor.number<std::uint16_t>();
  message.sequence = cursor.number<std::uint32_t>();
  message.time_ns = cursor.number<std::uint64_t>();
  (void)cursor.number<std::uint64_t>();  // time of publishing
  if (cursor.failed() || !known_channels_[message.channel]) {
    stop(McapEnd::kBroken);
    return false;
  }
  message.data = cursor.bytes(cursor.left());
  ++layout_.message_counts[message.channel];
  return true;
}

std::uint16_t McapReader::channel_of(std::string_view topic) const noexcept {
  for (const McapChannel& channel : layout_.channels) {
    if (channel.topic == topic) return channel.id;
  }
  return 0;
}

std::string McapReader::describe_end() const {
  const std::string at = " at byte " + std::to_string(place_);
  switch (end_) {
    case McapEnd::kMore:
      return "not read to its end";
    case McapEnd::kComplete:
      return "complete";
    case McapEnd::kTruncated:
      return "ends" + at + " without a summary, as a killed process leaves it";
    case McapEnd::kBroken:
      return "broken" + at;
    case McapEnd::kForeign:
      break;
  }
  return "compressed" + at + ": not a recording of hapticd";
}

McapRepair plan_repair(std::string_view bytes) {
  McapReader reader(bytes);
  McapMessage message;
  while (reader.next(message)) {
  }
  McapRepair repair;
  repair.reason = reader.describe_end();
  repair.keep = bytes.size();
  repair.possible = reader.end() == McapEnd::kComplete;
  if (repair.possible || reader.end() == McapEnd::kForeign || reader.layout().channels.empty()) {
    return repair;
  }
  std::string_view whole = bytes.substr(0, reader.whole_bytes());
  if (!last_chunk_indexed(whole, reader.layout())) {
    whole = whole.substr(0, reader.layout().chunks.back().offset);
  }
  // Once more over what stays, so that nothing is counted that goes.
  McapReader again(whole);
  while (again.next(message)) {
  }
  repair.possible = repair.needed = true;
  repair.keep = whole.size();
  repair.tail = summary_bytes(again.layout(), whole.size(), mcap_crc(whole));
  return repair;
}

bool finish_recording(const std::string& path, std::string& error) {
  McapRepair repair;
  {
    MappedFile file;
    if (!file.open(path, error)) return false;
    repair = plan_repair(file.bytes());
  }
  if (!repair.possible) {
    error = path + ": " + repair.reason;
    return false;
  }
  return !repair.needed || rewrite_end(path, repair.keep, repair.tail, error);
}

}  // namespace hapticd
