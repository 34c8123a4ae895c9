// The summary of a MCAP file. See mcap_layout.h.
#include "proto/recording/mcap_layout.h"

#include <algorithm>
#include <limits>

#include "proto/recording/mcap_bytes.h"

namespace hapticd {
namespace {

std::string chunk_index_content(const McapChunk& chunk) {
  std::string out;
  put(out, chunk.start_time);
  put(out, chunk.end_time);
  put(out, chunk.offset);
  put(out, chunk.length);
  std::string offsets;
  for (const auto& [channel, offset] : chunk.index_offsets) {
    put(offsets, channel);
    put(offsets, offset);
  }
  put_text(out, offsets);
  put(out, chunk.index_length);
  put_text(out, "");  // not compressed
  put(out, chunk.size);
  put(out, chunk.size);
  return out;
}

std::string statistics_content(const McapLayout& layout) {
  std::uint64_t messages = 0;
  std::string counts;
  for (const auto& [channel, count] : layout.message_counts) {
    messages += count;
    put(counts, channel);
    put(counts, count);
  }
  std::uint64_t start = layout.chunks.empty() ? 0 : std::numeric_limits<std::uint64_t>::max();
  std::uint64_t end = 0;
  for (const McapChunk& chunk : layout.chunks) {
    start = std::min(start, chunk.start_time);
    end = std::max(end, chunk.end_time);
  }
  std::string out;
  put(out, messages);
  put(out, static_cast<std::uint16_t>(layout.schemas.size()));
  put(out, static_cast<std::uint32_t>(layout.channels.size()));
  put(out, std::uint32_t{0});  // attachments
  put(out, std::uint32_t{0});  // metadata
  put(out, static_cast<std::uint32_t>(layout.chunks.size()));
  put(out, start);
  put(out, end);
  put_text(out, counts);
  return out;
}

/// A group of like records in the summary, and where it lies.
class SummaryGroups {
 public:
  explicit SummaryGroups(std::uint64_t start) : start_(start) {}

  void begin(McapOpcode opcode) {
    opcode_ = opcode;
    group_start_ = start_ + bytes_.size();
  }
  void add(std::string_view content) { put_record(bytes_, opcode_, content); }
  void end() {
    const std::uint64_t length = start_ + bytes_.size() - group_start_;
    if (length == 0) return;
    std::string content;
    content.push_back(static_cast<char>(opcode_));
    put(content, group_start_);
    put(content, length);
    put_record(offsets_, McapOpcode::kSummaryOffset, content);
  }

  [[nodiscard]] const std::string& bytes() const { return bytes_; }
  [[nodiscard]] const std::string& offsets() const { return offsets_; }

 private:
  std::uint64_t start_;
  std::uint64_t group_start_ = 0;
  McapOpcode opcode_ = McapOpcode::kSchema;
  std::string bytes_;
  std::string offsets_;
};

}  // namespace

std::string schema_content(const McapSchema& schema) {
  std::string out;
  put(out, schema.id);
  put_text(out, schema.name);
  put_text(out, schema.encoding);
  put_text(out, schema.data);
  return out;
}

std::string channel_content(const McapChannel& channel) {
  std::string out;
  put(out, channel.id);
  put(out, channel.schema_id);
  put_text(out, channel.topic);
  put_text(out, channel.encoding);
  put_text(out, "");  // metadata
  return out;
}

std::string summary_bytes(const McapLayout& layout, std::uint64_t data_end,
                          std::uint32_t data_crc) {
  std::string out;
  std::string content;
  put(content, data_crc);
  put_record(out, McapOpcode::kDataEnd, content);

  const std::uint64_t summary_start = data_end + out.size();
  SummaryGroups groups(summary_start);
  groups.begin(McapOpcode::kSchema);
  for (const McapSchema& schema : layout.schemas) groups.add(schema_content(schema));
  groups.end();
  groups.begin(McapOpcode::kChannel);
  for (const McapChannel& channel : layout.channels) groups.add(channel_content(channel));
  groups.end();
  groups.begin(McapOpcode::kStatistics);
  groups.add(statistics_content(layout));
  groups.end();
  groups.begin(McapOpcode::kChunkIndex);
  for (const McapChunk& chunk : layout.chunks) groups.add(chunk_index_content(chunk));
  groups.end();

  const std::uint64_t offsets_start = summary_start + groups.bytes().size();
  std::string tail = groups.bytes() + groups.offsets();
  // The footer's own CRC covers the summary and the footer up to that CRC.
  tail.push_back(static_cast<char>(McapOpcode::kFooter));
  put(tail, std::uint64_t{20});
  put(tail, summary_start);
  put(tail, offsets_start);
  put(tail, mcap_crc(tail));
  return out + tail + std::string(kMcapMagic);
}

}  // namespace hapticd
