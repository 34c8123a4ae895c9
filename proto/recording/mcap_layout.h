// What a MCAP file consists of besides its messages: schemas, channels and the place of each chunk;
// and the summary that is written from it at the end of a file. Not RT.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace hapticd {

struct McapSchema {
  std::uint16_t id = 0;  ///< > 0
  std::string name;      ///< full name of the message type
  std::string encoding;  ///< protobuf
  std::string data;      ///< a serialised FileDescriptorSet
};

struct McapChannel {
  std::uint16_t id = 0;
  std::uint16_t schema_id = 0;
  std::string topic;
  std::string encoding;  ///< of its messages
};

/// Where a chunk lies and what it holds.
struct McapChunk {
  std::uint64_t start_time = 0;  ///< of its messages, ns
  std::uint64_t end_time = 0;
  std::uint64_t offset = 0;                              ///< of its record in the file
  std::uint64_t length = 0;                              ///< of the record
  std::map<std::uint16_t, std::uint64_t> index_offsets;  ///< of its message indexes, by channel
  std::uint64_t index_length = 0;                        ///< of all of them
  std::uint64_t size = 0;                                ///< of its records; not compressed
};

struct McapLayout {
  std::vector<McapSchema> schemas;
  std::vector<McapChannel> channels;
  std::vector<McapChunk> chunks;
  std::map<std::uint16_t, std::uint64_t> message_counts;  ///< by channel
};

/// Content of a schema's and a channel's record.
[[nodiscard]] std::string schema_content(const McapSchema& schema);
[[nodiscard]] std::string channel_content(const McapChannel& channel);

/// All that follows the last chunk: end of data, summary, footer and magic, for a file whose data
/// ends at `data_end` with the CRC `data_crc` (of every byte before).
[[nodiscard]] std::string summary_bytes(const McapLayout& layout, std::uint64_t data_end,
                                        std::uint32_t data_crc);

}  // namespace hapticd
