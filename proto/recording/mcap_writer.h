// Writes MCAP files (mcap.dev): uncompressed chunks with CRC and index, a summary at the end. The
// file is only ever appended to, one write per chunk, so that a process killed at any instant loses
// what was not flushed yet and nothing else: McapReader takes the file as it is, and so does every
// reader of streams. An error (disk full) never throws: the file is cut back to its last whole
// chunk, the error is kept and messages are counted as lost. Want of memory is no error yet: a
// message that has no room is lost, a chunk that cannot be written waits for the next flush. Not
// RT.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/recording/mcap_layout.h"

namespace hapticd {

/// Bytes at which a chunk is written at the latest. Larger: fewer, longer writes; smaller: a larger
/// summary.
inline constexpr std::size_t kChunkBytes = 1U << 20U;
/// Bytes of a chunk that waits for memory, at most.
inline constexpr std::size_t kMaxChunkBytes = 8 * kChunkBytes;

class McapWriter {
 public:
  McapWriter() = default;
  /// Closes the file.
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  /// Creates `path`, which must not exist, for its owner alone; false with error() otherwise.
  /// `library`: who wrote it.
  bool open(const std::string& path, std::string_view library);

  /// A channel for messages of one protobuf type; returns its id. Before the first message.
  std::uint16_t add_channel(std::string_view topic, std::string_view type_name,
                            std::string_view file_descriptor_set);

  /// One message; it is in the file after the next flush. False: it is lost.
  bool write(std::uint16_t channel, std::uint64_t time_ns, std::string_view message);

  /// Appends the chunk so far, if any, to the file. Call at least every 100 ms.
  void flush();

  /// Flushes, appends the summary and closes. False when anything failed since open().
  bool close();

  [[nodiscard]] bool is_open() const noexcept { return file_ >= 0; }
  /// For people; empty: all is well.
  [[nodiscard]] const std::string& error() const noexcept { return error_; }
  /// error(), handed over: there is none from here on.
  [[nodiscard]] std::string take_error() noexcept { return std::exchange(error_, {}); }
  /// Whether nothing waits for the next flush: after one, false where memory was short.
  [[nodiscard]] bool flushed() const noexcept { return chunk_messages_ == 0; }
  /// Bytes in the file.
  [[nodiscard]] std::uint64_t bytes() const noexcept { return length_; }
  /// Messages that did not reach the file.
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }

 private:
  void put_message(std::size_t k, std::uint64_t time_ns, std::string_view message);
  [[nodiscard]] std::string chunk_bytes(McapChunk& chunk) const;
  void write_chunk();
  void forget_chunk();
  void fail_for_memory() noexcept;
  bool append(std::string_view bytes);
  void fail(const char* what, int code) noexcept;

  int file_ = -1;
  std::string path_;
  std::string error_;
  std::uint64_t length_ = 0;  ///< of what is whole
  std::uint32_t crc_ = 0;     ///< of it
  std::uint64_t lost_ = 0;
  McapLayout layout_;
  std::vector<std::uint32_t> sequence_;  ///< by channel
  std::string chunk_;
  std::uint64_t chunk_messages_ = 0;
  std::uint64_t start_time_ = 0;
  std::uint64_t end_time_ = 0;
  /// Time and place in the chunk of its messages, by channel.
  std::vector<std::vector<std::pair<std::uint64_t, std::uint64_t>>> index_;
};

}  // namespace hapticd
