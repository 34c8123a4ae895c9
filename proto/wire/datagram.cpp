// See datagram.h.
#include "proto/wire/datagram.h"

namespace hapticd::wire {
namespace {

constexpr std::uint8_t kMagic = 'H';

}  // namespace

std::array<std::uint8_t, kHeaderBytes> encode_header(const DatagramHeader& header) {
  std::array<std::uint8_t, kHeaderBytes> bytes{};
  bytes[0] = kMagic;
  bytes[1] = kWireMajor;
  bytes[2] = static_cast<std::uint8_t>(header.kind);
  for (std::size_t i = 0; i < 4; ++i) {
    bytes[4 + i] = static_cast<std::uint8_t>(header.session >> (8 * i));
  }
  for (std::size_t i = 0; i < 8; ++i) {
    bytes[8 + i] = static_cast<std::uint8_t>(header.counter >> (8 * i));
  }
  return bytes;
}

std::optional<DatagramHeader> decode_header(std::span<const std::uint8_t> datagram) {
  if (datagram.size() < kHeaderBytes || datagram.size() > kDatagramBytes) return std::nullopt;
  if (datagram[0] != kMagic || datagram[1] != kWireMajor || datagram[3] != 0) return std::nullopt;
  if (datagram[2] < static_cast<std::uint8_t>(DatagramKind::kHello) ||
      datagram[2] > static_cast<std::uint8_t>(DatagramKind::kPlain)) {
    return std::nullopt;
  }
  DatagramHeader header;
  header.kind = static_cast<DatagramKind>(datagram[2]);
  if (header.kind == DatagramKind::kData && datagram.size() < kHeaderBytes + kTagBytes) {
    return std::nullopt;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    header.session |= static_cast<std::uint32_t>(datagram[4 + i]) << (8 * i);
  }
  for (std::size_t i = 0; i < 8; ++i) {
    header.counter |= static_cast<std::uint64_t>(datagram[8 + i]) << (8 * i);
  }
  return header;
}

}  // namespace hapticd::wire
