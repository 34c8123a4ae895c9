// See mcap_reader.h.
#include "proto/recording/mcap_reader.h"

#include <utility>

namespace hapticd {
namespace {

/// Ids of schemas and channels there can be.
constexpr std::size_t kIds = 1U << 16U;

}  // namespace

McapReader::McapReader(std::string_view bytes)
    : bytes_(bytes), known_schemas_(kIds), known_channels_(kIds) {
  if (bytes_.substr(0, kMcapMagic.size()) == kMcapMagic) {
    place_ = kMcapMagic.size();
  } else {
    stop(kMcapMagic.substr(0, bytes_.size()) == bytes_ ? McapEnd::kTruncated : McapEnd::kBroken);
  }
}

void McapReader::stop(McapEnd end) noexcept {
  end_ = end;
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
  McapCursor cursor(bytes_.substr(place_));
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
  take(opcode, content);
  return end_ == McapEnd::kMore;
}

void McapReader::take(McapOpcode opcode, std::string_view content) {
  switch (opcode) {
    case McapOpcode::kSchema:
      take_schema(content);
      break;
    case McapOpcode::kChannel:
      take_channel(content);
      break;
    case McapOpcode::kChunk:
      take_chunk(content);
      break;
    case McapOpcode::kMessage:
      // Where there are chunks messages are in them: this one has no CRC and is a damaged index.
      if (chunked_) return stop(McapEnd::kBroken);
      message_ = content;
      has_message_ = true;
      break;
    case McapOpcode::kFooter:  // without an end of data
    case McapOpcode::kNone:
      stop(McapEnd::kBroken);
      break;
    default:  // indexes, attachments, metadata and what later versions add
      break;
  }
}

void McapReader::take_chunk(std::string_view content) {
  McapCursor cursor(content);
  (void)cursor.bytes(8 + 8);  // times of its first and last message
  const auto size = cursor.number<std::uint64_t>();
  const auto crc = cursor.number<std::uint32_t>();
  const std::string_view compression = cursor.text();
  const std::string_view records = cursor.bytes(cursor.number<std::uint64_t>());
  if (cursor.failed()) return stop(McapEnd::kBroken);
  if (!compression.empty()) return stop(McapEnd::kForeign);
  // A CRC of 0 says that there is none.
  if (records.size() != size || (crc != 0 && crc != mcap_crc(records))) {
    return stop(McapEnd::kBroken);
  }
  chunked_ = true;
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
  schemas_.push_back(std::move(schema));
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
  channels_.push_back(std::move(channel));
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
  return true;
}

std::uint16_t McapReader::channel_of(std::string_view topic) const noexcept {
  for (const McapChannel& channel : channels_) {
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

}  // namespace hapticd
