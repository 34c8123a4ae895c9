// A client of a server with keys, made of datagrams that are written here byte by byte from section
// 12 of PROTOCOL.md; only the Noise handshake itself is ours, and published vectors judge that.
#pragma once

#include <doctest/doctest.h>
#include <sodium.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proto/noise/handshake.h"
#include "tests/server/network/raw_peer.h"
#include "tests/support/random.h"

namespace hapticd::test {

/// The bytes of roles in a HELLO.
inline constexpr std::uint8_t kOldViewRole = 1;
inline constexpr std::uint8_t kOldControlRole = 2;
inline constexpr std::uint8_t kViewRole = 3;
inline constexpr std::uint8_t kControlRole = 4;

inline noise::Key filled_key(std::uint8_t byte) {
  noise::Key key;
  key.fill(byte);
  return key;
}
inline noise::Key view_key() { return filled_key(0x11); }
inline noise::Key control_key_of_tests() { return filled_key(0x22); }

/// Keys of tests.
inline noise::ServerKeys test_keys() {
  return noise::server_keys(noise::SecretKey(filled_key(0x33)), noise::SecretKey(view_key()),
                            noise::SecretKey(control_key_of_tests()));
}

/// Randomness of a server that is the same every time.
inline std::function<void(std::span<std::uint8_t>)> seeded_bytes(std::uint64_t seed) {
  auto random = std::make_shared<SplitMix64>(seed);
  return [random](std::span<std::uint8_t> bytes) {
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random->next() >> 56U);
  };
}

/// Options of a server with test_keys().
inline ServerOptions keyed_options() {
  return {.boot_id = 0xc0ffee, .keys = test_keys(), .random = seeded_bytes(3)};
}

/// BLAKE2b of `Bytes` bytes, keyed.
template <std::size_t Bytes>
noise::Bytes keyed_hash(std::span<const std::uint8_t> key, std::span<const std::uint8_t> data) {
  noise::Bytes hash(Bytes);
  REQUIRE(crypto_generichash_blake2b(hash.data(), hash.size(), data.data(), data.size(), key.data(),
                                     key.size()) == 0);
  return hash;
}
inline noise::Bytes bytes_of_text(const std::string& text) { return {text.begin(), text.end()}; }

/// One handshake of a client and what follows it; with a role of before, NNpsk0.
class KeyedClient {
 public:
  /// With `key` instead of the role's own.
  explicit KeyedClient(std::uint8_t role, std::uint64_t seed = 1,
                       std::optional<noise::Key> key = std::nullopt)
      : role_(role),
        psk_(key.value_or(role == kViewRole || role == kOldViewRole ? view_key()
                                                                    : control_key_of_tests())),
        handshake_(made(ephemeral(seed))),
        message_(handshake_->write().value()) {}

  [[nodiscard]] bool is_old() const { return role_ <= kOldControlRole; }
  [[nodiscard]] noise::Bytes prologue() const {
    return {'h', 'a', 'p', 't', 'i', 'c', 'd', 1, role_};
  }
  /// Noise message 1.
  [[nodiscard]] const noise::Bytes& message() const { return message_; }

  [[nodiscard]] noise::Bytes hello(const noise::Bytes& cookie = {}) const {
    noise::Bytes bytes = raw_header(1, 0, 0);
    const auto add = [&](const noise::Bytes& more) {
      bytes.insert(bytes.end(), more.begin(), more.end());
    };
    bytes.push_back(role_);
    bytes.push_back(static_cast<std::uint8_t>(cookie.size()));
    add(cookie);
    if (!is_old()) add(keyed_hash<8>(psk_, bytes_of_text("KEY ID")));
    add(message_);
    if (!is_old()) add(keyed_hash<16>(keyed_hash<32>(psk_, bytes_of_text("HELLO")), bytes));
    bytes.resize(1200);
    return bytes;
  }
  /// Takes a WELCOME; whether it opened.
  bool welcome(const noise::Bytes& datagram) {
    if (datagram.size() != 64 || datagram[2] != 3) return false;
    if (!handshake_->read(std::span(datagram).subspan(16)).has_value()) return false;
    session_ = 0;
    for (std::size_t i = 0; i < 4; ++i) session_ |= std::uint32_t{datagram[4 + i]} << (8 * i);
    transport_ = handshake_->split();
    return true;
  }
  /// DATA with this Packet.
  [[nodiscard]] noise::Bytes data(std::uint64_t counter, const v1::Packet& packet) const {
    noise::Bytes bytes = raw_header(4, session_, counter);
    const std::string body = packet.SerializeAsString();
    const noise::Bytes plain(body.begin(), body.end());
    const noise::Bytes sealed = transport_->send.seal(counter, bytes, plain);
    bytes.insert(bytes.end(), sealed.begin(), sealed.end());
    return bytes;
  }
  /// The Packet of a DATA of the server.
  [[nodiscard]] v1::Packet open(const SentDatagram& datagram) const {
    REQUIRE(datagram.raw[2] == 4);
    REQUIRE(datagram.session == session_);
    const std::span<const std::uint8_t> bytes = datagram.raw;
    const auto plain =
        transport_->receive.open(datagram.counter, bytes.first(16), bytes.subspan(16));
    REQUIRE(plain.has_value());
    v1::Packet packet;
    REQUIRE(packet.ParseFromArray(plain->data(), static_cast<int>(plain->size())));
    return packet;
  }
  [[nodiscard]] std::uint32_t session() const { return session_; }

 private:
  static noise::Key ephemeral(std::uint64_t seed) {
    SplitMix64 random(seed);
    noise::Key key;
    for (std::uint8_t& byte : key) byte = static_cast<std::uint8_t>(random.next() >> 56U);
    return key;
  }

  [[nodiscard]] std::unique_ptr<noise::Handshake> made(const noise::Key& ephemeral) const {
    constexpr auto kSide = noise::Side::kInitiator;
    if (is_old()) return std::make_unique<noise::Handshake>(kSide, psk_, prologue(), ephemeral);
    const noise::Key server = test_keys().server;
    return std::make_unique<noise::Handshake>(kSide, noise::Symmetric(psk_, prologue(), server),
                                              ephemeral, server);
  }

  std::uint8_t role_;
  noise::Key psk_;
  std::unique_ptr<noise::Handshake> handshake_;
  noise::Bytes message_;
  std::uint32_t session_ = 0;
  std::optional<noise::Transport> transport_;
};

/// A keyed client of a ServerBench that acknowledges by hand.
class KeyedPeer {
 public:
  explicit KeyedPeer(ServerBench& bench, std::uint8_t role = kControlRole,
                     std::uint16_t port = 40'000, std::uint64_t seed = 1)
      : client(role, seed), address(ipv4_address({127, 0, 0, 1}, port)), bench_(bench) {}

  /// HELLO, RETRY, HELLO, WELCOME; the second HELLO is kept in `hello`.
  void shake_hands() {
    bench_.receive(address, client.hello());
    REQUIRE(last().raw[2] == 2);
    const noise::Bytes retry = last().raw;
    hello = client.hello(noise::Bytes(retry.begin() + 16, retry.end()));
    bench_.receive(address, hello);
    REQUIRE(client.welcome(last().raw));
  }
  /// Sends these new Items; all before count as acknowledged.
  void send(const std::vector<v1::Item>& items = {}) {
    v1::Packet packet;
    packet.set_first(next_id_);
    for (const v1::Item& item : items) *packet.add_items() = item;
    next_id_ += items.size();
    packet.set_ack(received().size());
    captured.push_back(client.data(captured.size(), packet));
    bench_.receive(address, captured.back());
  }
  /// The Items of the server's DATA, in order.
  [[nodiscard]] std::vector<v1::Item> received() const {
    std::vector<v1::Item> all;
    for (const SentDatagram& datagram : bench_.sent) {
      if (datagram.to != address || datagram.raw[2] != 4) continue;
      const v1::Packet packet = client.open(datagram);
      for (int i = 0; i < packet.items_size(); ++i) {
        if (packet.first() + static_cast<std::uint64_t>(i) == all.size() + 1) {
          all.push_back(packet.items(i));
        }
      }
    }
    return all;
  }
  /// Code of the Result of request `id`; UNSPECIFIED if there is none.
  [[nodiscard]] v1::ResultCode code(std::uint64_t id) const {
    for (const v1::Item& item : received()) {
      if (item.has_result() && item.result().item_id() == id) return item.result().code();
    }
    return v1::RESULT_CODE_UNSPECIFIED;
  }
  [[nodiscard]] const SentDatagram& last() const {
    REQUIRE(!bench_.sent.empty());
    return bench_.sent.back();
  }

  KeyedClient client;
  Address address;
  noise::Bytes hello;
  std::vector<noise::Bytes> captured;  ///< its DATA

 private:
  ServerBench& bench_;
  std::uint64_t next_id_ = 1;
};

}  // namespace hapticd::test
