// The header of every datagram: PROTOCOL.md, section 2, steps 1 and 2. Pure, no allocation. Not RT.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace hapticd::wire {

/// Largest UDP payload, header and tag included, bytes: fits every path's MTU, so nothing is ever
/// fragmented.
inline constexpr std::size_t kDatagramBytes = 1200;
inline constexpr std::size_t kHeaderBytes = 16;
/// Authentication tag at the end of DATA, bytes.
inline constexpr std::size_t kTagBytes = 16;
inline constexpr std::uint8_t kWireMajor = 1;

/// Byte 2 of the header.
enum class DatagramKind : std::uint8_t {
  kHello = 1,
  kRetry = 2,
  kWelcome = 3,
  kData = 4,
  kPlain = 5,
};

struct DatagramHeader {
  DatagramKind kind = DatagramKind::kPlain;
  std::uint32_t session = 0;
  std::uint64_t counter = 0;

  friend bool operator==(const DatagramHeader&, const DatagramHeader&) = default;
};

/// The 16 bytes of `header`.
[[nodiscard]] std::array<std::uint8_t, kHeaderBytes> encode_header(const DatagramHeader& header);

/// Steps 1 and 2: nothing when the length is outside [16, 1200] (DATA: [32, 1200]), when bytes 0, 1
/// and 3 are not 'H', 1 and 0, or when the kind does not exist. Whether the kind is expected is the
/// caller's to say.
[[nodiscard]] std::optional<DatagramHeader> decode_header(std::span<const std::uint8_t> datagram);

}  // namespace hapticd::wire
