// Sessions of the server: opening, Reset, keep-alive, silence, Bye, backlog, junk. PROTOCOL.md,
// sections 2 to 4.
#include <doctest/doctest.h>

#include "tests/server/network/raw_peer.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

v1::Item tone_item() {
  v1::Item item;
  item.mutable_tone()->set_string_index(1);
  return item;
}

TEST_CASE("the first Items of a session are SceneInfo, LeaseInfo and RecordInfo") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  peer.keep_alive();
  bench.pass(1);
  const auto items = peer.items();
  REQUIRE(items.size() == 3);
  CHECK(items.at(1).has_scene_info());
  CHECK(items.at(2).has_lease_info());
  CHECK(items.at(3).has_record_info());
  CHECK(peer.received()[0].counter == 0);
  CHECK(peer.received()[0].packet.boot_id() == 0xc0ffee);
  CHECK(peer.states().empty());
}

TEST_CASE("a session opens with any counter, so that a lost first datagram does no harm") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  v1::Packet packet;
  packet.set_first(1);
  bench.receive(peer.address(), plain_datagram(5, 3, packet));
  CHECK(bench.server->session_count() == 1);
}

TEST_CASE("an unknown session with first above 1 or an ack gets a Reset, and leaves no trace") {
  for (const bool by_ack : {false, true}) {
    ServerBench bench;
    RawPeer peer(bench, 5);
    v1::Packet packet;
    packet.set_first(by_ack ? 1 : 2);
    packet.set_ack(by_ack ? 1 : 0);
    peer.send_packet(packet);
    REQUIRE(bench.sent.size() == 1);
    CHECK(bench.sent[0].packet.reset().reason() == v1::RESET_REASON_UNKNOWN_SESSION);
    CHECK(bench.sent[0].packet.first() == 1);
    CHECK(bench.sent[0].packet.boot_id() == 0xc0ffee);
    CHECK(bench.sent[0].counter == 0);
    CHECK(bench.sent[0].session == 5);
    CHECK(bench.server->session_count() == 0);
    CHECK(bench.server->counters().unknown_session == 1);
  }
}

TEST_CASE("an address gets at most one Reset in 100 ms, another address its own") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  RawPeer other(bench, 5, 40'001);
  v1::Packet packet;
  packet.set_first(2);
  for (int i = 0; i < 1000; ++i) {
    peer.send_packet(packet);
    bench.pass(1);
  }
  CHECK(bench.sent.size() == 10);
  other.send_packet(packet);
  CHECK(bench.sent.size() == 11);
}

TEST_CASE("the 33rd session gets a Reset FULL; one that has left makes room at once") {
  ServerBench bench;
  std::vector<std::unique_ptr<RawPeer>> peers;
  for (std::uint16_t i = 0; i < 33; ++i) {
    peers.push_back(std::make_unique<RawPeer>(bench, 5, static_cast<std::uint16_t>(40'000 + i)));
    peers.back()->send(acquire_item("peer"));
  }
  CHECK(bench.server->session_count() == 32);
  REQUIRE(peers[32]->received().size() == 1);
  CHECK(peers[32]->received()[0].packet.reset().reason() == v1::RESET_REASON_FULL);
  peers[3]->send(bye_item());
  RawPeer late(bench, 6, 41'000);
  late.keep_alive();
  bench.pass(1);
  CHECK(late.items().size() == 3);
}

TEST_CASE("of sessions that never asked for control 24 stay; beyond them the first gives way") {
  ServerBench bench;
  std::vector<std::unique_ptr<RawPeer>> lookers;
  const auto look = [&] {
    const auto port = static_cast<std::uint16_t>(40'000 + lookers.size());
    lookers.push_back(std::make_unique<RawPeer>(bench, 5, port));
    lookers.back()->send(subscribe_item(100));
  };
  const auto refused = [&](const RawPeer& peer) {
    for (const SentDatagram& datagram : peer.received()) {
      if (datagram.packet.reset().reason() == v1::RESET_REASON_FULL) return true;
    }
    return false;
  };
  for (int i = 0; i < 32; ++i) look();
  for (const auto& peer : lookers) CHECK_FALSE(refused(*peer));
  // One that has asked keeps its place from then on.
  lookers[25]->send(acquire_item("player"));
  for (int i = 0; i < 40; ++i) look();
  CHECK(bench.server->session_count() == 32);
  RawPeer operating(bench, 9, 45'000);
  operating.send(stop_item());
  REQUIRE(!bench.host.asked.empty());
  CHECK(bench.host.asked.back().item.has_stop());
  bench.pass(1);
  CHECK(operating.code(1) == v1::RESULT_CODE_OK);
  int gone = 0;
  for (std::size_t i = 0; i < lookers.size(); ++i) {
    CAPTURE(i);
    if (i < 24 || i == 25) CHECK_FALSE(refused(*lookers[i]));
    gone += refused(*lookers[i]) ? 1 : 0;
  }
  CHECK(gone == 32 + 40 + 1 - 32);
  CHECK(bench.server->lease_holder() == "player");
  CHECK(bench.server->session_count() == 32);
}

TEST_CASE("session 0 is nobody's") {
  ServerBench bench;
  RawPeer peer(bench, 0);
  peer.keep_alive();
  CHECK(bench.server->session_count() == 0);
  CHECK(bench.sent.empty());
}

TEST_CASE("the same number from another address is another session") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  RawPeer spoofer(bench, 5, 40'001);
  peer.send(acquire_item("peer"));
  v1::Packet packet;
  packet.set_first(2);
  *packet.add_items() = release_item();
  spoofer.send_packet(packet);
  bench.pass(1);
  CHECK(bench.server->lease_holder() == "peer");
  CHECK(peer.code(2) == v1::RESULT_CODE_UNSPECIFIED);
}

TEST_CASE("a Packet leaves at least every 100 ms") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  peer.keep_alive();
  bench.pass(5);
  peer.keep_alive();
  const std::size_t before = bench.sent.size();
  bench.pass(1000);
  CHECK(bench.sent.size() - before == 10);
}

TEST_CASE("a session is dropped after 10 s of silence, and told so once") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  peer.keep_alive();
  bench.pass(9999);
  CHECK(bench.server->session_count() == 1);
  CHECK(peer.bye() == v1::BYE_REASON_UNSPECIFIED);
  bench.pass(3);
  CHECK(bench.server->session_count() == 0);
  CHECK(peer.bye() == v1::BYE_REASON_SILENCE);
  CHECK(bench.server->counters().silences == 1);
}

TEST_CASE("junk does not keep a session alive, and costs no more than a counter") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  peer.keep_alive();
  bench.pass(1);
  const std::size_t sent = bench.sent.size();
  SplitMix64 random(3);
  const std::int64_t junk = scaled(100'000);
  for (std::int64_t i = 0; i < junk; ++i) {
    std::vector<std::uint8_t> bytes(random.below(1300));
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.next());
    if (bytes.size() > 3 && random.chance(0.5)) {
      bytes[0] = 0x48;
      bytes[1] = 1;
      bytes[2] = 5;
      bytes[3] = 0;
    }
    bench.receive(peer.address(), bytes);
  }
  CHECK(bench.sent.size() == sent);
  const ServerCounters& counters = bench.server->counters();
  CHECK(counters.bad_header + counters.unknown_session == static_cast<std::uint64_t>(junk));
  CHECK(counters.bad_header > 0);
  bench.pass(10'001);
  CHECK(bench.server->session_count() == 0);
}

TEST_CASE("a datagram that came before is dropped") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  v1::Packet packet;
  packet.set_first(1);
  *packet.add_items() = ping_item();
  const auto bytes = plain_datagram(5, 0, packet);
  bench.receive(peer.address(), bytes);
  bench.pass(10'001);
  CHECK(bench.server->session_count() == 0);
}

TEST_CASE("a Bye is acknowledged, ends the session at once, and is forgotten after 1 s") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  peer.send({acquire_item("peer"), subscribe_item(1)});
  bench.pass(1);
  bench.offer(1);
  CHECK(peer.states().size() == 1);
  peer.send(bye_item());
  CHECK(bench.server->fence() == 0);
  REQUIRE(bench.host.lease_ends.size() == 1);
  CHECK(bench.host.lease_ends[0] == LeaseEnd::kSessionEnded);
  bench.offer(2);
  CHECK(peer.states().size() == 1);
  bench.pass(1);
  CHECK(bench.sent.back().packet.ack() == 3);
  CHECK(bench.server->session_count() == 1);
  bench.pass(1000);
  CHECK(bench.server->session_count() == 0);
}

TEST_CASE("a Bye of the server is repeated until it is acknowledged, 1 s at most") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  RawPeer silent(bench, 6, 40'001);
  peer.keep_alive();
  silent.keep_alive();
  bench.pass(1);
  bench.server->shut_down(v1::BYE_REASON_SHUTDOWN, "the end", bench.now_ns);
  bench.pass(5);
  CHECK(peer.bye() == v1::BYE_REASON_SHUTDOWN);
  CHECK(bench.server->session_count() == 2);
  peer.keep_alive();
  bench.pass(1);
  CHECK(bench.server->session_count() == 1);
  bench.pass(1000);
  CHECK(bench.server->session_count() == 0);
  // Nobody new is let in.
  RawPeer late(bench, 7, 40'002);
  late.keep_alive();
  CHECK(bench.server->session_count() == 0);
  CHECK(late.received().empty());
}

TEST_CASE("with 1024 Items unacknowledged the session ends with Bye BACKLOG, none is left out") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  RawPeer other(bench, 6, 40'001);
  peer.keep_alive();
  other.keep_alive();
  bench.pass(1);
  peer.keep_alive();
  other.keep_alive();
  for (int i = 0; i < 1024; ++i) bench.server->broadcast(tone_item());
  CHECK(bench.server->counters().backlogs == 0);
  for (int i = 0; i < 80; ++i) {
    bench.pass(1);
    other.keep_alive();
  }
  bench.server->broadcast(tone_item());
  CHECK(bench.server->counters().backlogs == 1);
  for (int i = 0; i < 80; ++i) {
    bench.pass(1);
    other.keep_alive();
    peer.keep_alive();
  }
  CHECK(other.bye() == v1::BYE_REASON_UNSPECIFIED);
  CHECK(other.applied() == 3 + 1025);
  CHECK(peer.bye() == v1::BYE_REASON_BACKLOG);
  CHECK(peer.applied() == 3 + 1024 + 1);
}

TEST_CASE("a session that the server has ended is not opened again by a late first datagram") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  v1::Packet first;
  first.set_first(1);
  *first.add_items() = stop_item();
  peer.send_packet(first);
  CHECK(bench.host.asked.size() == 1);
  v1::Packet gap;
  gap.set_first(7);
  *gap.add_items() = ping_item();
  peer.send_packet(gap);
  bench.pass(1);
  REQUIRE(peer.bye() == v1::BYE_REASON_PROTOCOL_ERROR);
  v1::Packet acknowledging;
  acknowledging.set_first(2);
  acknowledging.set_ack(peer.applied());
  peer.send_packet(acknowledging);
  bench.pass(900);
  peer.send_packet(first);
  bench.receive(peer.address(), plain_datagram(5, 0, first));
  CHECK(bench.host.asked.size() == 1);
}

TEST_CASE("a Bye behind many Items is repeated as long as those are acknowledged, 10 s at most") {
  for (const std::int64_t every_ms : {100, 900}) {
    CAPTURE(every_ms);
    ServerBench bench;
    RawPeer peer(bench, 5);
    peer.keep_alive();
    bench.pass(1);
    peer.keep_alive();
    for (int i = 0; i < 320; ++i) bench.server->broadcast(tone_item());
    bench.server->shut_down(v1::BYE_REASON_SHUTDOWN, "the end", bench.now_ns);
    for (int i = 0; i < 25; ++i) {
      bench.pass(every_ms);
      peer.keep_alive();
    }
    CHECK(bench.server->session_count() == 0);
    CHECK((peer.bye() == v1::BYE_REASON_SHUTDOWN) == (every_ms == 100));
  }
}

TEST_CASE("a gap in the Items ends the session with Bye PROTOCOL_ERROR") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  peer.send(acquire_item("peer"));
  v1::Packet packet;
  packet.set_first(7);
  *packet.add_items() = ping_item();
  peer.send_packet(packet);
  bench.pass(1);
  CHECK(peer.bye() == v1::BYE_REASON_PROTOCOL_ERROR);
  CHECK(bench.server->fence() == 0);
  CHECK(bench.server->counters().protocol_errors == 1);
}

TEST_CASE("a Clock is echoed in the next Packet, with arrival and departure") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  v1::Packet packet;
  packet.mutable_clock()->set_sent_ns(77);
  peer.keep_alive(packet);
  const std::int64_t arrived = bench.now_ns;
  bench.pass(1);
  const v1::Clock clock = peer.received()[0].packet.clock();
  CHECK(clock.echoed_ns() == 77);
  CHECK(clock.received_ns() == static_cast<std::uint64_t>(arrived));
  CHECK(clock.sent_ns() == static_cast<std::uint64_t>(arrived + kTestMs / 2));
}

TEST_CASE("a SceneInfo larger than a datagram arrives in Chunks, piece after acknowledged piece") {
  ServerBench bench;
  std::string& version = *bench.host.greeting[0].mutable_scene_info()->mutable_server_version();
  version.assign(5000, 'v');
  RawPeer peer(bench, 5);
  peer.keep_alive();
  std::int64_t rounds = 0;
  while (peer.applied() < 8 && rounds < 100) {
    bench.pass(1);
    peer.keep_alive();
    ++rounds;
  }
  CHECK(rounds < 15);
  std::string blob;
  for (const auto& [id, item] : peer.items()) blob += item.chunk().bytes();
  v1::Item whole;
  REQUIRE(whole.ParseFromString(blob));
  CHECK(whole.scene_info().server_version() == version);
  for (const SentDatagram& datagram : bench.sent) CHECK(datagram.bytes <= 1200);
}

}  // namespace
}  // namespace hapticd::test
