// Reads MCAP files (mcap.dev) of any writer, from the front to the back, chunked or not (but
// not both), uncompressed: what replay and export need. Bytes are not trusted: lengths are
// checked, CRCs too, and a file that ends anywhere, as a killed process leaves it, gives all its
// whole records. Not RT.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "proto/recording/mcap_bytes.h"
#include "proto/recording/mcap_layout.h"

namespace hapticd {

/// A message in a file; views are into the bytes read from.
struct McapMessage {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  std::uint64_t time_ns = 0;
  std::string_view data;
};

/// How a reading ended.
enum class McapEnd : std::uint8_t {
  kMore,       ///< it has not
  kComplete,   ///< end of data, then the footer and the magic at the very end
  kTruncated,  ///< the bytes end in the middle, or before the summary
  kBroken,     ///< a CRC or a length is wrong, or it is not an MCAP file
  kForeign,    ///< compressed: not ours
};

class McapReader {
 public:
  /// `bytes` must outlive the reader.
  explicit McapReader(std::string_view bytes);

  /// The next message in the order of the file; false at its end, see end().
  bool next(McapMessage& message);

  [[nodiscard]] McapEnd end() const noexcept { return end_; }
  /// For people, once end() is not kMore.
  [[nodiscard]] std::string describe_end() const;
  /// Schemas and channels met so far.
  [[nodiscard]] const std::vector<McapSchema>& schemas() const noexcept { return schemas_; }
  [[nodiscard]] const std::vector<McapChannel>& channels() const noexcept { return channels_; }
  /// Id of the channel of this topic met so far, 0: none.
  [[nodiscard]] std::uint16_t channel_of(std::string_view topic) const noexcept;

 private:
  bool next_record();
  void take(McapOpcode opcode, std::string_view content);
  void take_chunk(std::string_view content);
  void take_schema(std::string_view content);
  void take_channel(std::string_view content);
  bool take_message(std::string_view content, McapMessage& message);
  void stop(McapEnd end) noexcept;

  std::string_view bytes_;
  std::vector<bool> known_schemas_;   ///< by id
  std::vector<bool> known_channels_;  ///< by id
  std::uint64_t place_ = 0;
  bool chunked_ = false;      ///< there was a chunk
  std::string_view chunk_;    ///< what is left of the present chunk's records
  std::string_view message_;  ///< content of a message outside of chunks
  bool has_message_ = false;
  McapEnd end_ = McapEnd::kMore;
  std::vector<McapSchema> schemas_;
  std::vector<McapChannel> channels_;
};

}  // namespace hapticd
