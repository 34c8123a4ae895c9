// The header of a datagram against the table of PROTOCOL.md, section 2.
#include "proto/wire/datagram.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Header of datagram 2 of the document.
Bytes worked_header() {
  return {0x48, 0x01, 0x05, 0x00, 0xcd, 0xab, 0x34, 0x12, 7, 0, 0, 0, 0, 0, 0, 0};
}

TEST_CASE("a header is encoded as the document has it") {
  const auto bytes = encode_header({DatagramKind::kPlain, 0x1234abcd, 7});
  CHECK(Bytes(bytes.begin(), bytes.end()) == worked_header());
  const auto other = encode_header({DatagramKind::kData, 1, 0x0102030405060708U});
  CHECK(other[2] == 4);
  CHECK(other[8] == 8);
  CHECK(other[15] == 1);
}

TEST_CASE("a header is decoded to what was encoded") {
  test::SplitMix64 random(1);
  for (std::int64_t n = test::scaled(10'000); n > 0; --n) {
    DatagramHeader header;
    header.kind = static_cast<DatagramKind>(1 + random.below(5));
    header.session = static_cast<std::uint32_t>(random.next());
    header.counter = random.next();
    const auto bytes = encode_header(header);
    Bytes datagram(bytes.begin(), bytes.end());
    datagram.resize(kHeaderBytes + kTagBytes);
    const auto decoded = decode_header(datagram);
    REQUIRE(decoded.has_value());
    CHECK(*decoded == header);
  }
}

TEST_CASE("datagrams shorter than 16 or longer than 1200 bytes are refused") {
  for (std::size_t size = 0; size <= 1300; ++size) {
    Bytes datagram = worked_header();
    datagram.resize(size);
    CHECK(decode_header(datagram).has_value() == (size >= 16 && size <= 1200));
  }
}

TEST_CASE("DATA shorter than header and tag is refused") {
  for (std::size_t size = 16; size <= 40; ++size) {
    Bytes datagram = worked_header();
    datagram[2] = 4;
    datagram.resize(size);
    CHECK(decode_header(datagram).has_value() == (size >= 32));
  }
}

TEST_CASE("another magic, major, kind or fourth byte is refused") {
  for (int place = 0; place < 4; ++place) {
    for (int value = 0; value < 256; ++value) {
      Bytes datagram = worked_header();
      datagram.resize(64);
      const std::uint8_t before = datagram[static_cast<std::size_t>(place)];
      datagram[static_cast<std::size_t>(place)] = static_cast<std::uint8_t>(value);
      const bool good = place == 2 ? value >= 1 && value <= 5 : value == before;
      CHECK(decode_header(datagram).has_value() == good);
    }
  }
}

}  // namespace
}  // namespace hapticd::wire
