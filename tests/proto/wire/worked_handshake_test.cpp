// The handshake worked out in proto/PROTOCOL.md, section 16: its blocks are read from the document;
// what both sides make of the keys named there must be those bytes. PROTOCOL.md, section 12.
#include <doctest/doctest.h>

#include <fstream>
#include <numeric>
#include <sstream>
#include <string>
#include <vector>

#include "proto/wire/hello.h"

namespace hapticd::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Bytes of each "hex handshake" block, in order.
std::vector<Bytes> worked_blocks() {
  std::ifstream file(HAPTICD_SOURCE_DIR "/proto/PROTOCOL.md");
  REQUIRE(file.good());
  std::vector<Bytes> blocks;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line == "```hex handshake") {
      inside = true;
      blocks.emplace_back();
    } else if (line == "```") {
      inside = false;
    } else if (inside) {
      std::istringstream words(line.substr(0, line.find('#')));
      for (std::string word; words >> word;) {
        blocks.back().push_back(static_cast<std::uint8_t>(std::stoul(word, nullptr, 16)));
      }
    }
  }
  return blocks;
}

/// first, first + 1, to first + 31.
noise::Key counting_key(std::uint8_t first) {
  noise::Key key;
  std::iota(key.begin(), key.end(), first);
  return key;
}

TEST_CASE("the keys of the document give its server key, its HELLO and its WELCOME") {
  const std::vector<Bytes> blocks = worked_blocks();
  REQUIRE(blocks.size() == 3);
  const noise::Key psk = counting_key(0);
  const noise::Key server = noise::public_half(counting_key(0x20));
  CHECK(Bytes(server.begin(), server.end()) == blocks[0]);

  const noise::Symmetric start(psk, prologue_of(Role::kControl, Method::kNKpsk0), server);
  noise::Handshake client(noise::Side::kInitiator, start, counting_key(0x40), server);
  const noise::Bytes message = client.write().value();
  Bytes hello = blocks[1];
  hello.resize(1200);
  CHECK(encode_hello({Role::kControl, noise::key_id(psk), {}, message}, noise::hello_key(psk)) ==
        hello);

  noise::Handshake responder(noise::Side::kResponder, start, counting_key(0x60),
                             counting_key(0x20));
  REQUIRE(responder.read(message).has_value());
  CHECK(encode_welcome({0x1234abcd, responder.write().value()}) == blocks[2]);
  CHECK(client.read(std::span(blocks[2]).subspan(16)).has_value());
}

TEST_CASE("the HELLO of the document is read as what it says beside its bytes") {
  const std::vector<Bytes> blocks = worked_blocks();
  REQUIRE(blocks.size() == 3);
  Bytes datagram = blocks[1];
  datagram.resize(1200);
  const auto hello = decode_hello(datagram);
  REQUIRE(hello.has_value());
  CHECK(hello->role == Role::kControl);
  CHECK(hello->method == Method::kNKpsk0);
  CHECK(hello->cookie.empty());
  CHECK(hello->before.size() == 74);
  CHECK(noise::is_hello_tag(noise::hello_key(counting_key(0)), hello->before, hello->tag));
  const noise::KeyId id = noise::key_id(counting_key(0));
  CHECK(std::equal(id.begin(), id.end(), hello->key_id.begin(), hello->key_id.end()));
}

}  // namespace
}  // namespace hapticd::wire
