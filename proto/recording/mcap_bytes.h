// The bytes of MCAP (mcap.dev, specification version 0): little-endian numbers, text with a 32-bit
// length, records of an opcode and a 64-bit length. Appending to a string, and taking from a view
// that never reads past its end. Not RT.
#pragma once

#include <zlib.h>

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace hapticd {

/// First and last bytes of every file.
inline constexpr std::string_view kMcapMagic{"\x89MCAP0\r\n", 8};

/// Kinds of record.
enum class McapOpcode : std::uint8_t {
  kNone = 0x00,  ///< no record begins so
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

/// Opcode and length in front of every record's content.
inline constexpr std::size_t kMcapPrefix = 9;

/// Appends `value`, little-endian.
template <std::unsigned_integral T>
void put(std::string& out, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    out.push_back(static_cast<char>(static_cast<unsigned char>(value >> (8 * i))));
  }
}

/// Appends a text with its length; below 4 GiB.
inline void put_text(std::string& out, std::string_view text) {
  put(out, static_cast<std::uint32_t>(text.size()));
  out.append(text);
}

/// Appends a whole record.
inline void put_record(std::string& out, McapOpcode opcode, std::string_view content) {
  out.push_back(static_cast<char>(opcode));
  put(out, static_cast<std::uint64_t>(content.size()));
  out.append(content);
}

/// CRC-32 (ISO 3309, zlib's) of the bytes so far, whose CRC is `crc` (0 at the start), followed by
/// `bytes`. About 1 ns a byte.
[[nodiscard]] inline std::uint32_t mcap_crc(std::string_view bytes,
                                            std::uint32_t crc = 0) noexcept {
  // zlib starts anew where there is no buffer at all.
  if (bytes.empty()) return crc;
  const auto* data = reinterpret_cast<const Bytef*>(bytes.data());
  return static_cast<std::uint32_t>(crc32_z(crc, data, bytes.size()));
}

/// Takes values from the front of bytes; once something is missing it has failed, gives zeros and
/// takes no more.
class McapCursor {
 public:
  explicit McapCursor(std::string_view bytes) noexcept : rest_(bytes) {}

  /// The next little-endian number; 0 on failure.
  template <std::unsigned_integral T>
  T number() noexcept {
    const std::string_view taken = bytes(sizeof(T));
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < taken.size(); ++i) {
      value |= static_cast<std::uint64_t>(static_cast<unsigned char>(taken[i])) << (8 * i);
    }
    return static_cast<T>(value);
  }

  /// The next `count` bytes; none on failure.
  std::string_view bytes(std::uint64_t count) noexcept {
    if (count > rest_.size()) {
      failed_ = true;
      rest_ = {};
      return {};
    }
    const std::string_view taken = rest_.substr(0, static_cast<std::size_t>(count));
    rest_.remove_prefix(taken.size());
    return taken;
  }

  /// A text with its 32-bit length.
  std::string_view text() noexcept { return bytes(number<std::uint32_t>()); }

  [[nodiscard]] bool failed() const noexcept { return failed_; }
  [[nodiscard]] std::size_t left() const noexcept { return rest_.size(); }

 private:
  std::string_view rest_;
  bool failed_ = false;
};

}  // namespace hapticd
