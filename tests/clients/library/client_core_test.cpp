// The client's side against Packets written field by field. PROTOCOL.md, sections 3, 4, 6 and 11.
#include "clients/library/client_core.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

namespace hapticd::client {
namespace {

constexpr std::int64_t kMs = 1'000'000;

/// A client whose datagrams are kept, and a server that is this test.
struct Bench {
  std::vector<v1::Packet> sent;
  std::vector<SessionEnd> ends;
  std::vector<v1::Item> items;
  std::uint32_t next_session = 100;
  std::uint64_t counter = 0;
  std::int64_t now_ns = 1000 * kMs;
  ClientCore core{
      [this](std::span<const std::uint8_t> bytes) {
        v1::Packet packet;
        REQUIRE(packet.ParseFromArray(bytes.data() + 16, static_cast<int>(bytes.size()) - 16));
        sent.push_back(packet);
      },
      [this] { return next_session++; }, handlers()};

  ClientHandlers handlers() {
    ClientHandlers all;
    all.ended = [this](SessionEnd how) { ends.push_back(how); };
    all.item = [this](const v1::Item& item) { items.push_back(item); };
    return all;
  }

  void give(v1::Packet packet, std::uint32_t boot_id = 5) {
    packet.set_boot_id(boot_id);
    if (packet.first() == 0) packet.set_first(1);
    const auto header =
        wire::encode_header({wire::DatagramKind::kPlain, core.session(), counter++});
    std::vector<std::uint8_t> datagram(header.begin(), header.end());
    const std::string body = packet.SerializeAsString();
    datagram.insert(datagram.end(), body.begin(), body.end());
    core.receive(datagram, now_ns);
  }
  void poll() { core.poll(now_ns); }
};

v1::Packet state_packet(std::uint64_t tick) {
  v1::Packet packet;
  packet.mutable_state()->set_tick(tick);
  packet.mutable_state()->set_scene_id(1);
  return packet;
}

TEST_CASE("the first Packet has first 1, ack 0 and a Clock") {
  Bench bench;
  CHECK(bench.core.due_ns() == 0);
  bench.poll();
  REQUIRE(bench.sent.size() == 1);
  CHECK(bench.sent[0].first() == 1);
  CHECK(bench.sent[0].ack() == 0);
  CHECK(bench.sent[0].clock().sent_ns() == static_cast<std::uint64_t>(bench.now_ns));
}

TEST_CASE("another boot id ends the session, and nothing of that Packet is applied") {
  Bench bench;
  bench.poll();
  bench.give({}, 5);
  const std::uint32_t before = bench.core.session();
  v1::Packet packet;
  packet.add_items()->mutable_tone();
  bench.give(packet, 6);
  REQUIRE(bench.ends.size() == 1);
  CHECK(bench.ends[0] == SessionEnd::kRestarted);
  CHECK(bench.core.session() != before);
}

TEST_CASE("States are told of after the sixteenth, not with the keep-alive alone") {
  Bench bench;
  bench.poll();
  for (std::uint64_t tick = 0; tick < 15; ++tick) bench.give(state_packet(tick));
  CHECK(bench.core.due_ns() > bench.now_ns);
  bench.give(state_packet(15));
  CHECK(bench.core.due_ns() <= bench.now_ns);
  bench.poll();
  CHECK(bench.sent.back().seen() == 16);
  CHECK(bench.sent.back().newest() == 15);
  CHECK(bench.core.due_ns() > bench.now_ns);
}

TEST_CASE("Items that come early are skipped, and taken when their turn comes") {
  Bench bench;
  bench.poll();
  CHECK(bench.sent[0].ahead() == 32);
  v1::Packet packet;
  packet.set_first(2);
  packet.add_items()->mutable_tone();
  bench.give(packet);
  CHECK(bench.items.empty());
  bench.now_ns += 10'000'000;
  bench.poll();
  CHECK(bench.sent.back().ack() == 0);
  CHECK(bench.sent.back().ahead() == 0);
  packet.set_first(1);
  bench.give(packet);
  packet.set_first(2);
  bench.give(packet);
  CHECK(bench.items.size() == 2);
  bench.poll();
  CHECK(bench.sent.back().ack() == 2);
  CHECK(bench.ends.empty());
}

TEST_CASE("a Chunk out of place ends the session with Bye PROTOCOL_ERROR") {
  Bench bench;
  bench.poll();
  v1::Packet packet;
  packet.add_items()->mutable_chunk()->set_blob(2);
  bench.give(packet);
  bench.poll();
  REQUIRE(bench.ends.size() == 1);
  CHECK(bench.ends[0] == SessionEnd::kProtocolError);
  REQUIRE(bench.sent.back().items_size() == 1);
  CHECK(bench.sent.back().items(0).bye().reason() == v1::BYE_REASON_PROTOCOL_ERROR);
}

TEST_CASE("Items of a later version are acknowledged and skipped") {
  Bench bench;
  bench.poll();
  v1::Packet packet;
  packet.add_items();
  packet.add_items()->mutable_tone();
  bench.give(packet);
  bench.poll();
  CHECK(bench.sent.back().ack() == 2);
  REQUIRE(bench.items.size() == 1);
  CHECK(bench.items[0].has_tone());
}

TEST_CASE("datagrams of another session or another kind are not looked at") {
  Bench bench;
  bench.poll();
  v1::Packet packet;
  packet.set_first(1);
  packet.add_items()->mutable_tone();
  for (const auto kind : {wire::DatagramKind::kPlain, wire::DatagramKind::kRetry}) {
    const std::uint32_t session =
        bench.core.session() + (kind == wire::DatagramKind::kPlain ? 1U : 0U);
    const auto header = wire::encode_header({kind, session, 0});
    std::vector<std::uint8_t> datagram(header.begin(), header.end());
    const std::string body = packet.SerializeAsString();
    datagram.insert(datagram.end(), body.begin(), body.end());
    bench.core.receive(datagram, bench.now_ns);
  }
  CHECK(bench.items.empty());
  CHECK(!bench.core.heard());
}

}  // namespace
}  // namespace hapticd::client
