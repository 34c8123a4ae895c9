// Who has a place among the sessions of a server with keys, and who gives way. PROTOCOL.md,
// section 12.
#include <doctest/doctest.h>

#include <memory>
#include <vector>

#include "tests/server/network/keyed_peer.h"

namespace hapticd::test {
namespace {

/// Peers that come one after the other, each with a handshake of its own.
struct Crowd {
  ServerBench bench{keyed_options()};
  std::vector<std::unique_ptr<KeyedPeer>> peers;

  KeyedPeer& add(std::uint8_t role, const Address& from) {
    peers.push_back(std::make_unique<KeyedPeer>(bench, role, from.port, 100 + peers.size()));
    peers.back()->address = from;
    bench.pass(60);  // Those of one address share its limit.
    peers.back()->shake_hands();
    for (const auto& peer : peers) peer->send();
    return *peers.back();
  }
  /// Whether the newest datagram to the peer is a Reset FULL; its message.
  [[nodiscard]] std::string refusal(const KeyedPeer& peer) const {
    std::string message;
    for (const SentDatagram& datagram : bench.sent) {
      if (datagram.to != peer.address || datagram.raw[2] != 4) continue;
      const v1::Packet packet = peer.client.open(datagram);
      if (packet.reset().reason() == v1::RESET_REASON_FULL) message = packet.reset().message();
    }
    return message;
  }
};

Address host(int i, int port = 5000) {
  return ipv4_address({10, 0, 1, static_cast<std::uint8_t>(i)}, static_cast<std::uint16_t>(port));
}

TEST_CASE("one address has a quarter of the places of those who look, and is told so") {
  Crowd crowd;
  for (int i = 0; i < 6; ++i) crowd.add(kViewRole, host(1, 5000 + i));
  CHECK(crowd.bench.server->session_count() == 6);
  const KeyedPeer& refused = crowd.add(kViewRole, host(1, 6000));
  CHECK(crowd.bench.server->session_count() == 6);
  CHECK(!crowd.refusal(refused).empty());
  crowd.add(kViewRole, host(2));
  crowd.add(kControlRole, host(1, 7000));
  CHECK(crowd.bench.server->session_count() == 8);
  CHECK(crowd.bench.server->counters().full == 1);
}

TEST_CASE("viewers of this machine fill all places of those who look, and give way to another's") {
  Crowd crowd;
  const auto here = [](int i) {
    return ipv4_address({127, 0, 0, 1}, static_cast<std::uint16_t>(40'000 + i));
  };
  for (int i = 0; i < 24; ++i) crowd.add(kViewRole, here(i));
  CHECK(crowd.bench.server->session_count() == 24);
  // All but the fourth ask for something: it is the idlest.
  for (int i = 0; i < 24; ++i) {
    if (i != 3) crowd.peers[static_cast<std::size_t>(i)]->send({ping_item()});
  }
  crowd.add(kViewRole, host(1));
  CHECK(crowd.bench.server->session_count() == 24);
  CHECK(crowd.bench.server->counters().evicted == 1);
  CHECK(!crowd.refusal(*crowd.peers[3]).empty());
  CHECK(crowd.refusal(*crowd.peers[4]).empty());
  crowd.add(kViewRole, here(30));
  CHECK(!crowd.refusal(*crowd.peers.back()).empty());
}

TEST_CASE("where all places are taken the idlest viewer gives way to the control key, told why") {
  Crowd crowd;
  for (int i = 0; i < 24; ++i) crowd.add(kViewRole, host(1 + i / 6, 5000 + i));
  for (int i = 0; i < 8; ++i) crowd.add(kControlRole, host(50, 5000 + i));
  CHECK(crowd.bench.server->session_count() == 32);
  for (int i = 0; i < 32; ++i) {
    if (i != 17) crowd.peers[static_cast<std::size_t>(i)]->send({ping_item()});
  }
  KeyedPeer& operating = crowd.add(kControlRole, host(60));
  CHECK(crowd.bench.server->session_count() == 32);
  CHECK(!crowd.refusal(*crowd.peers[17]).empty());
  for (int i = 0; i < 32; ++i) {
    if (i != 17) CHECK(crowd.refusal(*crowd.peers[static_cast<std::size_t>(i)]).empty());
  }
  operating.send({stop_item()});
  CHECK(crowd.bench.host.asked.back().item.has_stop());
  // Nobody looks any more: then the control key, too, finds no place.
  for (int i = 0; i < 23; ++i) crowd.add(kControlRole, host(61 + i));
  CHECK(crowd.bench.server->counters().evicted == 24);
  CHECK(!crowd.refusal(crowd.add(kControlRole, host(100))).empty());
  CHECK(crowd.bench.server->session_count() == 32);
}

}  // namespace
}  // namespace hapticd::test
