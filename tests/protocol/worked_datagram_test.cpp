// The datagrams worked out in proto/PROTOCOL.md: bytes, text and header values are read from the
// document; what protobuf makes of the text, behind the header, must be those bytes.
#include <doctest/doctest.h>
#include <google/protobuf/text_format.h>

#include <cstdint>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "hapticd/v1/stream.pb.h"
#include "tests/protocol/message_walk.h"

namespace hapticd::test {
namespace {

struct WorkedDatagram {
  std::string title;
  std::uint64_t session = 0;
  std::uint64_t counter = 0;
  std::string text;   ///< the Packet in text format
  std::string bytes;  ///< the whole datagram
};

/// Bytes of lines such as "1a 08    # items[0]".
std::string bytes_of(const std::string& hex_block) {
  std::string bytes;
  std::istringstream lines(hex_block);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line.substr(0, line.find('#')));
    for (std::string word; words >> word;) {
      CAPTURE(line);
      REQUIRE(std::regex_match(word, std::regex("[0-9a-f]{2}")));
      bytes += static_cast<char>(std::stoi(word, nullptr, 16));
    }
  }
  return bytes;
}

std::vector<WorkedDatagram> worked_datagrams() {
  std::ifstream file(HAPTICD_SOURCE_DIR "/proto/PROTOCOL.md");
  REQUIRE(file.good());
  std::vector<WorkedDatagram> found;
  std::string* block = nullptr;
  std::string hex;
  std::smatch match;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("### Datagram", 0) == 0) {
      found.push_back({});
      found.back().title = line;
    } else if (std::regex_match(line, match, std::regex("session 0x(\\w+), counter (\\d+)"))) {
      found.back().session = std::stoull(match[1], nullptr, 16);
      found.back().counter = std::stoull(match[2]);
    } else if (line == "```textproto") {
      block = &found.back().text;
    } else if (line == "```hex") {
      hex.clear();
      block = &hex;
    } else if (line == "```") {
      if (block == &hex) found.back().bytes = bytes_of(hex);
      block = nullptr;
    } else if (block != nullptr) {
      *block += line + '\n';
    }
  }
  return found;
}

/// Section 2 of the document: 'H', major, kind PLAIN, 0, session and counter, little-endian.
std::string plain_header(std::uint64_t session, std::uint64_t counter) {
  std::string header("H\x01\x05\x00", 4);
  for (int i = 0; i < 4; ++i) header += static_cast<char>(session >> (8 * i));
  for (int i = 0; i < 8; ++i) header += static_cast<char>(counter >> (8 * i));
  return header;
}

TEST_CASE("the document works out a client's, a server's and a Reset datagram") {
  const std::vector<WorkedDatagram> all = worked_datagrams();
  REQUIRE(all.size() >= 3);
  for (const WorkedDatagram& datagram : all) {
    CAPTURE(datagram.title);
    CHECK(datagram.session != 0);
    CHECK(!datagram.text.empty());
    CHECK(datagram.bytes.size() > 16);
    CHECK(datagram.bytes.size() <= 1200);
  }
}

TEST_CASE("header and text of each worked datagram give its bytes") {
  for (const WorkedDatagram& datagram : worked_datagrams()) {
    CAPTURE(datagram.title);
    v1::Packet packet;
    REQUIRE(google::protobuf::TextFormat::ParseFromString(datagram.text, &packet));
    const std::string built =
        plain_header(datagram.session, datagram.counter) + packet.SerializeAsString();
    CHECK(built == datagram.bytes);
  }
}

TEST_CASE("the bytes of each worked datagram give its header and text") {
  for (const WorkedDatagram& datagram : worked_datagrams()) {
    CAPTURE(datagram.title);
    CHECK(datagram.bytes.substr(0, 16) == plain_header(datagram.session, datagram.counter));
    v1::Packet from_bytes;
    REQUIRE(from_bytes.ParseFromString(datagram.bytes.substr(16)));
    v1::Packet from_text;
    REQUIRE(google::protobuf::TextFormat::ParseFromString(datagram.text, &from_text));
    ValueMap values_of_bytes;
    ValueMap values_of_text;
    add_values(from_bytes, "", values_of_bytes);
    add_values(from_text, "", values_of_text);
    CHECK(values_of_bytes == values_of_text);
  }
}

}  // namespace
}  // namespace hapticd::test
