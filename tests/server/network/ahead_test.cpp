// How a server sends Packets of Items ahead: to whom, how many at once, and whose come first.
// PROTOCOL.md, section 4.
#include <doctest/doctest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "tests/server/network/raw_peer.h"

namespace hapticd::test {
namespace {

constexpr std::size_t kLarge = 100'000;

/// A greeting whose SceneInfo is a blob.
void lengthen(ServerBench& bench) {
  bench.host.greeting[0].mutable_scene_info()->set_server_version(std::string(kLarge, 'v'));
}

/// Opens a session that takes `ahead` Packets ahead.
void open(RawPeer& peer, std::uint32_t ahead) {
  v1::Packet packet;
  packet.set_ahead(ahead);
  peer.keep_alive(packet);
}

/// Packets with Items that leave with the next poll.
std::size_t packets_of_poll(ServerBench& bench, const RawPeer& peer) {
  const std::size_t before = peer.received().size();
  bench.now_ns += kTestMs / 2;
  bench.server->poll(bench.now_ns);
  const auto all = peer.received();
  std::size_t count = 0;
  for (std::size_t i = before; i < all.size(); ++i) count += all[i].packet.items_size() > 0;
  return count;
}

/// Lets the client acknowledge all that came, until as many leave at once as may.
void acknowledge_often(ServerBench& bench, RawPeer& peer) {
  for (int i = 0; i < 5; ++i) {
    packets_of_poll(bench, peer);
    peer.keep_alive();
  }
}

TEST_CASE("who announced it is sent twice as many Packets at once as it acknowledged, up to 32") {
  ServerBench bench;
  lengthen(bench);
  RawPeer peer(bench, 5);
  open(peer, 32);
  std::vector<std::size_t> left;
  for (int i = 0; i < 7; ++i) {
    left.push_back(packets_of_poll(bench, peer));
    CHECK(peer.received().back().packet.ahead() == (i == 0 ? 32 : 0));
    peer.keep_alive();
  }
  CHECK(left == std::vector<std::size_t>{1, 2, 4, 8, 16, 32, 32});
  std::uint64_t next = 1;
  for (const SentDatagram& datagram : peer.received()) {
    CHECK(datagram.packet.first() == next);
    next += static_cast<std::uint64_t>(datagram.packet.items_size());
  }
}

TEST_CASE("who announced nothing is sent the oldest Items alone, and nothing is said of it") {
  ServerBench bench;
  lengthen(bench);
  RawPeer peer(bench, 5);
  open(peer, 0);
  std::size_t rounds = 0;
  for (; peer.applied() < 100; ++rounds) {
    CHECK(packets_of_poll(bench, peer) == 1);
    peer.keep_alive();
  }
  CHECK(rounds == 100);
  std::uint64_t acknowledged = 0;
  for (const SentDatagram& datagram : peer.received()) {
    CHECK(datagram.packet.ahead() == 0);
    CHECK(datagram.packet.first() == acknowledged + 1);
    ++acknowledged;
  }
}

TEST_CASE("no more leave at once than the client announced") {
  for (const std::uint32_t ahead : {1U, 2U, 7U, 33U, 0xffffffffU}) {
    CAPTURE(ahead);
    ServerBench bench;
    lengthen(bench);
    RawPeer peer(bench, 5);
    open(peer, ahead);
    acknowledge_often(bench, peer);
    CHECK(packets_of_poll(bench, peer) == std::min(ahead, 32U));
  }
}

TEST_CASE("Packets of several sessions leave in turns, 64 of all beyond the first of each") {
  ServerBench bench;
  lengthen(bench);
  std::vector<std::unique_ptr<RawPeer>> peers;
  for (std::uint32_t i = 0; i < 5; ++i) {
    peers.push_back(
        std::make_unique<RawPeer>(bench, 5 + i, static_cast<std::uint16_t>(40'000 + i)));
    open(*peers.back(), 32);
  }
  for (int i = 0; i < 5; ++i) {
    bench.now_ns += kTestMs / 2;
    bench.server->poll(bench.now_ns);
    for (const auto& peer : peers) peer->keep_alive();
  }
  const std::size_t before = bench.sent.size();
  bench.now_ns += kTestMs / 2;
  bench.server->poll(bench.now_ns);
  REQUIRE(bench.sent.size() - before == 5 + 64);
  for (std::size_t i = before; i < bench.sent.size(); ++i) {
    CHECK(bench.sent[i].session == 5 + (i - before) % 5);
  }
  bench.now_ns += kTestMs / 2;
  bench.server->poll(bench.now_ns);
  for (std::uint32_t i = 0; i < 5; ++i) {
    std::size_t under_way = 0;
    for (std::size_t k = before; k < bench.sent.size(); ++k) {
      under_way += bench.sent[k].session == 5 + i;
    }
    CHECK(under_way >= 26);
    CHECK(under_way <= 32);
  }
}

TEST_CASE("early Items of a client that was told so are skipped, and carried out in their turn") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  open(peer, 32);
  bench.pass(1);
  const auto ask = [&](std::uint64_t first) {
    v1::Packet packet;
    packet.set_first(first);
    packet.set_ack(peer.applied());
    v1::Item item;
    item.mutable_get_parameters()->add_paths(std::to_string(first));
    *packet.add_items() = item;
    peer.send_packet(packet);
    bench.pass(1);
  };
  ask(3);
  ask(2);
  CHECK(bench.host.asked.empty());
  CHECK(peer.bye() == v1::BYE_REASON_UNSPECIFIED);
  bench.pass(10);
  CHECK(peer.received().back().packet.ack() == 0);
  ask(1);
  ask(2);
  ask(3);
  REQUIRE(bench.host.asked.size() == 3);
  for (std::uint64_t i = 0; i < 3; ++i) CHECK(bench.host.asked[i].id.item == i + 1);
}

TEST_CASE(
    "the answer to a Stop does not wait for a listing, nor LeaseInfo for anything but its Result") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  open(peer, 32);
  bench.pass(1);
  bench.host.answers = false;
  v1::Item list;
  list.mutable_list_recordings();
  peer.send({list, acquire_item("peer")});
  bench.pass(1);
  REQUIRE(bench.host.asked.size() == 1);
  v1::Result listing = result_with();
  listing.mutable_listing()->add_names(std::string(kLarge, 'r'));
  bench.server->answer(bench.host.asked[0].id, listing);
  bench.pass(1);
  bench.host.answers = true;
  peer.send(stop_item());
  bench.pass(1);
  peer.keep_alive();
  bench.pass(1);
  std::vector<std::string> order;
  for (const auto& [id, item] : peer.items()) {
    if (item.has_result()) order.push_back("result " + std::to_string(item.result().item_id()));
    if (item.has_lease_info() && item.lease_info().fence() != 0) order.push_back("lease");
  }
  CHECK(order == std::vector<std::string>{"result 2", "lease", "result 3"});
}

}  // namespace
}  // namespace hapticd::test
