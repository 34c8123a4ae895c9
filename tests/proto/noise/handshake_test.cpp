// The handshake against published vectors, and what damaged or foreign messages do to it.
#include "proto/noise/handshake.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/random.h"

namespace hapticd::noise {
namespace {

using test::SplitMix64;

Bytes bytes_of(const std::string& hex) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

Key key_from(const Bytes& bytes) {
  REQUIRE(bytes.size() == kKeyBytes);
  Key key;
  std::copy(bytes.begin(), bytes.end(), key.begin());
  return key;
}

Key random_key(SplitMix64& random) {
  Key key;
  for (std::uint8_t& byte : key) byte = static_cast<std::uint8_t>(random.next());
  return key;
}

/// Names and bytes of each published vector.
std::vector<std::map<std::string, Bytes>> published_vectors(const std::string& file_name) {
  std::ifstream file(HAPTICD_NOISE_VECTORS "/" + file_name);
  std::vector<std::map<std::string, Bytes>> vectors;
  for (std::string line; std::getline(file, line);) {
    const std::size_t equals = line.find('=');
    if (line.starts_with('#') || equals == std::string::npos) continue;
    const std::string name = line.substr(0, equals);
    if (name == "handshake") {
      vectors.emplace_back();
    } else {
      vectors.back()[name] = bytes_of(line.substr(equals + 1));
    }
  }
  return vectors;
}

struct Pair {
  Handshake client;
  Handshake server;

  /// NNpsk0.
  explicit Pair(SplitMix64& random) : Pair(random, random_key(random)) {}
  Pair(SplitMix64& random, const Key& psk)
      : client(Side::kInitiator, psk, {}, random_key(random)),
        server(Side::kResponder, psk, {}, random_key(random)) {}
  /// NKpsk0: the client knows the responder by `known`, the server has `own`.
  Pair(SplitMix64& random, const Key& psk, const Key& known, const Key& own)
      : client(Side::kInitiator, Symmetric(psk, {}, known), random_key(random), known),
        server(Side::kResponder, Symmetric(psk, {}, known), random_key(random), own) {}
};

/// Every message of a published vector, written and read.
void meet(const std::map<std::string, Bytes>& vector, Handshake& client, Handshake& server) {
  CHECK(client.write(vector.at("msg_0_payload")) == vector.at("msg_0_ciphertext"));
  CHECK(server.read(vector.at("msg_0_ciphertext")) == vector.at("msg_0_payload"));
  CHECK(server.write(vector.at("msg_1_payload")) == vector.at("msg_1_ciphertext"));
  CHECK(client.read(vector.at("msg_1_ciphertext")) == vector.at("msg_1_payload"));
  const Transport at_client = client.split();
  const Transport at_server = server.split();
  CHECK(at_client.send.seal(0, {}, vector.at("msg_2_payload")) == vector.at("msg_2_ciphertext"));
  CHECK(at_server.receive.open(0, {}, vector.at("msg_2_ciphertext")) == vector.at("msg_2_payload"));
  CHECK(at_server.send.seal(0, {}, vector.at("msg_3_payload")) == vector.at("msg_3_ciphertext"));
  CHECK(at_client.receive.open(0, {}, vector.at("msg_3_ciphertext")) == vector.at("msg_3_payload"));
}

Bytes prologue_of(const std::map<std::string, Bytes>& vector) {
  return vector.count("prologue") == 0 ? Bytes{} : vector.at("prologue");
}

TEST_CASE("every message of every published vector of NNpsk0 is met, written and read") {
  const auto vectors = published_vectors("noise_nnpsk0_vectors.txt");
  CHECK(vectors.size() == 4);
  for (const auto& vector : vectors) {
    const Key psk = key_from(vector.at("preshared_key"));
    const Bytes prologue = prologue_of(vector);
    Handshake client(Side::kInitiator, psk, prologue, key_from(vector.at("gen_init_ephemeral")));
    Handshake server(Side::kResponder, psk, prologue, key_from(vector.at("gen_resp_ephemeral")));
    meet(vector, client, server);
  }
}

TEST_CASE("every message of every published vector of NKpsk0 is met, written and read") {
  const auto vectors = published_vectors("noise_nkpsk0_vectors.txt");
  CHECK(vectors.size() == 4);
  for (const auto& vector : vectors) {
    const Key own = key_from(vector.at("resp_static"));
    const Symmetric start(key_from(vector.at("preshared_key")), prologue_of(vector),
                          public_half(own));
    Handshake client(Side::kInitiator, start, key_from(vector.at("gen_init_ephemeral")),
                     public_half(own));
    Handshake server(Side::kResponder, start, key_from(vector.at("gen_resp_ephemeral")), own);
    meet(vector, client, server);
  }
}

TEST_CASE("who has the psk and not the responder's private key cannot pose as the responder") {
  SplitMix64 random(6);
  const Key psk = random_key(random);
  const Key own = random_key(random);
  Pair honest(random, psk, public_half(own), own);
  REQUIRE(honest.server.read(honest.client.write().value()).has_value());
  CHECK(honest.client.read(honest.server.write().value()).has_value());
  // Another private key does not open the first message, and what it answers is not believed.
  Pair posing(random, psk, public_half(own), random_key(random));
  const Bytes first = posing.client.write().value();
  CHECK(!posing.server.read(first).has_value());
  Handshake without(Side::kResponder, psk, {}, random_key(random));
  Handshake old_client(Side::kInitiator, psk, {}, random_key(random));
  REQUIRE(without.read(old_client.write().value()).has_value());
  CHECK(!posing.client.read(without.write().value()).has_value());
}

TEST_CASE("no message with a flipped bit is read, and the true one still is") {
  const auto each_flip = [](const Bytes& message, Handshake& reader) {
    for (std::size_t bit = 0; bit < 8 * message.size(); ++bit) {
      Bytes bad = message;
      bad[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
      CHECK(!reader.read(bad).has_value());
    }
    for (std::size_t length = 0; length < message.size(); ++length) {
      CHECK(!reader.read(std::span(message).first(length)).has_value());
    }
    CHECK(reader.read(message).value().empty());
  };
  SplitMix64 random(1);
  const Key own = random_key(random);
  Pair old(random);
  Pair pair(random, random_key(random), public_half(own), own);
  for (Pair* each : {&old, &pair}) {
    const Bytes first = each->client.write().value();
    CHECK(first.size() == kMessageBytes);
    each_flip(first, each->server);
    each_flip(each->server.write().value(), each->client);
  }
}

TEST_CASE("neither another key nor another prologue opens the first message") {
  SplitMix64 random(2);
  const Key psk = random_key(random);
  const Bytes prologue{1, 2, 3};
  Handshake client(Side::kInitiator, psk, prologue, random_key(random));
  const Bytes first = client.write().value();
  Handshake other_key(Side::kResponder, random_key(random), prologue, random_key(random));
  CHECK(!other_key.read(first).has_value());
  Handshake other_prologue(Side::kResponder, psk, Bytes{1, 2, 4}, random_key(random));
  CHECK(!other_prologue.read(first).has_value());
}

TEST_CASE("a message with a public key of low order is not read") {
  SplitMix64 random(3);
  const Key psk = random_key(random);
  Pair pair(random, psk);
  Bytes message = pair.client.write().value();
  REQUIRE(pair.server.read(message).has_value());
  Bytes second = pair.server.write().value();
  std::fill_n(second.begin(), kKeyBytes, std::uint8_t{0});
  CHECK(!pair.client.read(second).has_value());
}

TEST_CASE("transport opens only with its counter, its header and its direction") {
  SplitMix64 random(4);
  Pair pair(random);
  REQUIRE(pair.server.read(pair.client.write().value()).has_value());
  REQUIRE(pair.client.read(pair.server.write().value()).has_value());
  const Transport client = pair.client.split();
  const Transport server = pair.server.split();
  const Bytes header{'H', 1, 4, 0};
  const Bytes plain{1, 2, 3, 4, 5};
  const Bytes sealed = client.send.seal(1ULL << 40U, header, plain);
  CHECK(sealed.size() == plain.size() + kTagBytes);
  CHECK(server.receive.open(1ULL << 40U, header, sealed) == plain);
  CHECK(!server.receive.open((1ULL << 40U) + 1, header, sealed).has_value());
  CHECK(!server.receive.open(1ULL << 40U, plain, sealed).has_value());
  CHECK(!client.receive.open(1ULL << 40U, header, sealed).has_value());
  for (std::size_t length = 0; length < sealed.size(); ++length) {
    CHECK(!server.receive.open(1ULL << 40U, header, std::span(sealed).first(length)).has_value());
  }
}

TEST_CASE("messages out of turn are the caller's error") {
  SplitMix64 random(5);
  Pair pair(random);
  CHECK_THROWS_AS((void)pair.server.write(), std::logic_error);
  CHECK_THROWS_AS((void)pair.client.read({}), std::logic_error);
  CHECK_THROWS_AS((void)pair.client.split(), std::logic_error);
  (void)pair.client.write();
  CHECK_THROWS_AS((void)pair.client.write(), std::logic_error);
}

}  // namespace
}  // namespace hapticd::noise
