// Sessions of a server with keys: how they begin, what they may, and what cannot touch them.
// PROTOCOL.md, sections 2 and 12.
#include <doctest/doctest.h>

#include <memory>
#include <numeric>

#include "tests/server/network/keyed_peer.h"

namespace hapticd::test {
namespace {

v1::Packet first_packet() {
  v1::Packet packet;
  packet.set_first(1);
  return packet;
}

TEST_CASE("the first DATA opens the session, and it begins as every other") {
  ServerBench bench(keyed_options());
  KeyedPeer peer(bench);
  peer.shake_hands();
  CHECK(bench.server->session_count() == 0);
  bench.pass(500);
  CHECK(bench.sent.size() == 2);
  peer.send({acquire_item("peer"), engage_item()});
  bench.pass(1);
  CHECK(bench.server->session_count() == 1);
  const auto items = peer.received();
  REQUIRE(items.size() >= 5);
  CHECK(items[0].has_scene_info());
  CHECK(items[1].has_lease_info());
  CHECK(items[2].has_record_info());
  CHECK(peer.code(1) == v1::RESULT_CODE_OK);
  CHECK(peer.code(2) == v1::RESULT_CODE_OK);
  CHECK(bench.server->lease_holder() == "peer");
}

TEST_CASE("before the first DATA opens no more bytes leave than came") {
  ServerBench bench(keyed_options());
  KeyedPeer peer(bench);
  std::size_t in = std::size_t{2} * 1200;
  peer.shake_hands();
  noise::Bytes forged = peer.client.data(0, first_packet());
  forged.back() ^= 1U;
  for (int i = 0; i < 100; ++i) {
    bench.receive(peer.address, peer.hello);
    bench.receive(peer.address, forged);
    in += peer.hello.size() + forged.size();
    bench.pass(20);
    const std::size_t out = std::accumulate(
        bench.sent.begin(), bench.sent.end(), std::size_t{0},
        [](std::size_t sum, const SentDatagram& datagram) { return sum + datagram.bytes; });
    CHECK(out <= in);
  }
  CHECK(bench.server->session_count() == 0);
}

TEST_CASE("a server with keys speaks no PLAIN, and answers no RETRY, WELCOME or unknown DATA") {
  ServerBench bench(keyed_options());
  const Address from = ipv4_address({127, 0, 0, 1}, 40'000);
  bench.receive(from, plain_datagram(5, 0, first_packet()));
  for (const std::uint8_t kind : {std::uint8_t{2}, std::uint8_t{3}, std::uint8_t{4}}) {
    noise::Bytes bytes = raw_header(kind, 5, 0);
    bytes.resize(64);
    bench.receive(from, bytes);
  }
  bench.pass(200);
  CHECK(bench.sent.empty());
  CHECK(bench.server->session_count() == 0);
}

TEST_CASE("the view key may look and listen, and nothing else") {
  ServerBench bench(keyed_options());
  KeyedPeer peer(bench, kViewRole);
  peer.shake_hands();
  std::vector<v1::Item> permitted(6);
  permitted[0].mutable_subscribe()->set_divisor(1);
  permitted[1].mutable_ping();
  permitted[2].mutable_get_parameters();
  permitted[3].mutable_list_scenes();
  permitted[4].mutable_list_gestures();
  permitted[5].mutable_get_device_info();
  std::vector<v1::Item> refused(16);
  refused[0].mutable_acquire();
  refused[1].mutable_stop();
  refused[2].mutable_release();
  refused[3].mutable_engage();
  refused[4].mutable_disengage();
  refused[5].mutable_clear();
  refused[6].mutable_load_scene();
  refused[7].mutable_set_parameter();
  refused[8].mutable_pose_batch();
  refused[9].mutable_run()->set_mode(v1::RUN_MODE_STOP);
  refused[10].mutable_play_gesture();
  refused[11].mutable_replay();
  refused[12].mutable_record();
  refused[13].mutable_calibrate();
  refused[14].mutable_recentre();
  refused[15].mutable_clutch();
  peer.send(permitted);
  bench.pass(20);  // Two of them look at files.
  peer.send(refused);
  bench.pass(1);
  peer.send();
  bench.pass(1);
  for (std::uint64_t id = 1; id <= 6; ++id) CHECK(peer.code(id) == v1::RESULT_CODE_OK);
  for (std::uint64_t id = 7; id <= 22; ++id) {
    CAPTURE(id);
    CHECK(peer.code(id) == v1::RESULT_CODE_NOT_PERMITTED);
  }
  CHECK(bench.host.asked.size() == 4);
  CHECK(bench.server->fence() == 0);
}

TEST_CASE("no flipped bit of a DATA is taken, and the true one is not blocked by it") {
  ServerBench bench(keyed_options());
  KeyedPeer peer(bench);
  peer.shake_hands();
  peer.send();
  v1::Packet packet = first_packet();
  *packet.add_items() = acquire_item("peer");
  const noise::Bytes good = peer.client.data(1, packet);
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    noise::Bytes bad = good;
    bad[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    bench.receive(peer.address, bad);
  }
  for (std::size_t length = 0; length < good.size(); ++length) {
    bench.receive(peer.address, std::span(good).first(length));
  }
  CHECK(bench.server->fence() == 0);
  CHECK(bench.server->counters().forged > 8 * (good.size() - 16));
  CHECK(bench.server->session_count() == 1);
  bench.receive(peer.address, good);
  CHECK(bench.server->fence() == 1);
}

TEST_CASE("datagrams sent again, or from elsewhere, are not accepted and end nothing") {
  ServerBench bench(keyed_options());
  KeyedPeer peer(bench);
  peer.shake_hands();
  peer.send({acquire_item("peer")});
  for (int i = 0; i < 20; ++i) peer.send({ping_item(), engage_item()});
  bench.pass(1);
  const std::size_t asked = bench.host.asked.size();
  CHECK(asked == 20);
  const std::uint64_t repeated = bench.server->counters().repeated;
  for (const noise::Bytes& datagram : peer.captured) bench.receive(peer.address, datagram);
  CHECK(bench.server->counters().repeated == repeated + peer.captured.size());
  const Address elsewhere = ipv4_address({127, 0, 0, 1}, 40'001);
  v1::Packet packet;
  packet.set_first(42);
  *packet.add_items() = release_item();
  const noise::Bytes fresh = peer.client.data(1000, packet);
  bench.receive(elsewhere, fresh);
  for (const noise::Bytes& datagram : peer.captured) bench.receive(elsewhere, datagram);
  bench.pass(1000);
  bench.receive(peer.address, peer.hello);
  CHECK(peer.last().raw[2] == 3);
  bench.receive(elsewhere, peer.hello);
  CHECK(peer.last().raw[2] == 2);
  bench.pass(500);
  CHECK(bench.host.asked.size() == asked);
  CHECK(bench.server->session_count() == 1);
  CHECK(bench.server->lease_holder() == "peer");
  peer.send({ping_item()});
  for (int i = 0; i < 5; ++i) {
    bench.pass(1);
    peer.send();
  }
  CHECK(peer.code(42) == v1::RESULT_CODE_OK);
}

TEST_CASE("what was sent in a session that is over opens no other") {
  ServerBench bench(keyed_options());
  KeyedPeer peer(bench);
  peer.shake_hands();
  peer.send({acquire_item("peer"), engage_item()});
  bench.pass(12'000);
  CHECK(bench.server->session_count() == 0);
  const std::size_t asked = bench.host.asked.size();
  bench.receive(peer.address, peer.hello);
  CHECK(peer.last().raw[2] == 3);
  for (const noise::Bytes& datagram : peer.captured) bench.receive(peer.address, datagram);
  bench.pass(1);
  CHECK(bench.server->session_count() == 0);
  CHECK(bench.host.asked.size() == asked);
}

TEST_CASE("a handshake without DATA is over after 3 s") {
  ServerBench bench(keyed_options());
  KeyedPeer peer(bench);
  peer.shake_hands();
  bench.pass(3001);
  peer.send();
  CHECK(bench.server->session_count() == 0);
  CHECK(bench.server->counters().unknown_session == 1);
}

TEST_CASE("the first DATA from another address opens no session, and blocks none") {
  ServerBench bench(keyed_options());
  KeyedPeer peer(bench);
  peer.shake_hands();
  const noise::Bytes first = peer.client.data(0, first_packet());
  for (const Address& elsewhere :
       {ipv4_address({127, 0, 0, 1}, 40'001), ipv4_address({127, 0, 0, 2}, 40'000)}) {
    bench.receive(elsewhere, first);
  }
  CHECK(bench.server->session_count() == 0);
  CHECK(bench.server->counters().unknown_session == 2);
  bench.receive(peer.address, first);
  CHECK(bench.server->session_count() == 1);
}

TEST_CASE("a DATA that is no Packet opens no session, and the next one does") {
  ServerBench bench(keyed_options());
  KeyedPeer peer(bench);
  peer.shake_hands();
  bench.receive(peer.address, peer.client.data(7, {}));  // first = 0
  CHECK(bench.server->session_count() == 0);
  CHECK(bench.server->counters().unreadable == 1);
  peer.send();
  CHECK(bench.server->session_count() == 1);
}

TEST_CASE(
    "the 33rd keyed session is told that the server is full, and of those that look the 25th") {
  for (const bool control : {true, false}) {
    ServerBench bench(keyed_options());
    std::vector<std::unique_ptr<KeyedPeer>> peers;
    const std::uint16_t places = control ? 32 : 24;
    for (std::uint16_t i = 0; i <= places; ++i) {
      peers.push_back(std::make_unique<KeyedPeer>(bench, control ? kControlRole : kViewRole,
                                                  static_cast<std::uint16_t>(40'000 + i),
                                                  std::uint64_t{100} + i));
      bench.pass(150);  // All of them share the limit of one address.
      peers.back()->shake_hands();
      for (const auto& each : peers) each->send();
    }
    CHECK(bench.server->session_count() == places);
    const v1::Packet refused = peers[places]->client.open(peers[places]->last());
    CHECK(refused.reset().reason() == v1::RESET_REASON_FULL);
    CHECK(refused.boot_id() == 0xc0ffee);
    CHECK(refused.items_size() == 0);
  }
}

TEST_CASE("beside as many as may look the control key has eight places, and says Stop") {
  ServerBench bench(keyed_options());
  std::vector<std::unique_ptr<KeyedPeer>> peers;
  for (std::uint16_t i = 0; i < 40; ++i) {
    const bool control = i >= 32;
    peers.push_back(std::make_unique<KeyedPeer>(bench, control ? kControlRole : kViewRole,
                                                static_cast<std::uint16_t>(40'000 + i),
                                                std::uint64_t{100} + i));
    bench.pass(150);
    peers.back()->shake_hands();
    if (control) {
      peers.back()->send({stop_item()});
      REQUIRE(bench.host.asked.size() == i - 31U);
      CHECK(bench.host.asked.back().item.has_stop());
    }
    // The key of those that look is refused; they go on all the same.
    for (const auto& each : peers) each->send();
  }
  CHECK(bench.server->session_count() == 32);
}

TEST_CASE("handshakes of the view key leave room for those of the control key") {
  ServerBench bench(keyed_options());
  const auto at = [](std::size_t i) {
    return ipv4_address({10, 0, 1, static_cast<std::uint8_t>(i)}, 5000);
  };
  const auto answer = [&](const KeyedClient& client, const Address& from) {
    bench.receive(from, client.hello());
    const noise::Bytes retry = bench.sent.back().raw;
    const std::size_t before = bench.sent.size();
    bench.receive(from, client.hello({retry.begin() + 16, retry.end()}));
    return bench.sent.size() > before && bench.sent.back().raw[2] == 3;
  };
  int views = 0;
  for (std::size_t i = 0; i < 100; ++i) {
    views += answer(KeyedClient(kViewRole, i), at(i)) ? 1 : 0;
  }
  CHECK(views == 48);
  int controls = 0;
  for (std::size_t i = 100; i < 120; ++i) {
    controls += answer(KeyedClient(kControlRole, i), at(i)) ? 1 : 0;
  }
  CHECK(controls == 16);
}

/// test_keys() and those of clients, of even bytes.
noise::ServerKeys with_clients(const std::vector<std::pair<std::string, std::uint8_t>>& clients) {
  noise::ServerKeys keys = test_keys();
  for (const auto& [name, byte] : clients) {
    keys.known.push_back({name, wire::Role::kControl, noise::SecretKey(filled_key(byte))});
  }
  return keys;
}

/// A peer of the bench with the control key of a client.
struct NamedPeer : KeyedPeer {
  NamedPeer(ServerBench& bench, std::uint8_t byte, std::uint16_t port)
      : KeyedPeer(bench, kControlRole, port, port) {
    client = KeyedClient(kControlRole, port, filled_key(byte));
  }
};

/// A server that knows two clients by name.
ServerOptions stage_and_hall() {
  ServerOptions options = keyed_options();
  options.keys = with_clients({{"stage", 0x44}, {"hall", 0x45}});
  return options;
}

TEST_CASE("a session has the name of the key it came with, and the host is told of both ends") {
  ServerBench bench(stage_and_hall());
  NamedPeer stage(bench, 0x44, 40'001);
  NamedPeer hall(bench, 0x45, 40'002);
  KeyedPeer shared(bench, kViewRole, 40'003, 3);
  for (KeyedPeer* each :
       {static_cast<KeyedPeer*>(&stage), static_cast<KeyedPeer*>(&hall), &shared}) {
    each->shake_hands();
    each->send();
  }
  REQUIRE(bench.host.notices.size() == 3);
  CHECK(bench.host.notices[0].key_name == "stage");
  CHECK(bench.host.notices[1].key_name == "hall");
  CHECK(bench.host.notices[2].key_name.empty());
  CHECK(bench.host.notices[0].may_control);
  CHECK(!bench.host.notices[2].may_control);
  CHECK(bench.host.notices[1].address == hall.address);
  bench.pass(12'000);
  REQUIRE(bench.host.notices.size() == 6);
  CHECK(bench.host.notices[3].serial == bench.host.notices[0].serial);
  CHECK(!bench.host.notices[3].begins);
}

TEST_CASE("the sessions of a key that is revoked end and are told why, and others go on") {
  ServerBench bench(stage_and_hall());
  NamedPeer stage(bench, 0x44, 40'001);
  NamedPeer hall(bench, 0x45, 40'002);
  KeyedPeer shared(bench, kControlRole, 40'003, 3);
  NamedPeer waiting(bench, 0x44, 40'004);
  for (KeyedPeer* each :
       {static_cast<KeyedPeer*>(&stage), static_cast<KeyedPeer*>(&hall), &shared}) {
    each->shake_hands();
    each->send();
  }
  stage.send({acquire_item("stage")});
  bench.pass(1);
  CHECK(bench.server->lease_holder() == "stage");
  waiting.shake_hands();
  bench.server->replace_keys(with_clients({{"hall", 0x45}, {"new", 0x46}}), bench.now_ns);
  bench.pass(1);
  CHECK(stage.received().back().bye().reason() == v1::BYE_REASON_REVOKED);
  CHECK(stage.received().back().bye().message().find("stage was revoked") != std::string::npos);
  CHECK(bench.server->fence() == 0);
  CHECK(bench.server->counters().revoked == 1);
  // Neither its session nor a handshake that was under way leads anywhere.
  const std::size_t asked = bench.host.asked.size();
  stage.send({stop_item()});
  waiting.send({stop_item()});
  CHECK(bench.host.asked.size() == asked);
  bench.pass(150);
  const std::size_t sent = bench.sent.size();
  NamedPeer again(bench, 0x44, 40'005);
  bench.receive(again.address, again.client.hello());
  CHECK(bench.sent.size() == sent);
  hall.send({stop_item()});
  shared.send({stop_item()});
  CHECK(bench.host.asked.size() == asked + 2);
  NamedPeer fresh(bench, 0x46, 40'006);
  fresh.shake_hands();
  fresh.send({stop_item()});
  CHECK(bench.host.asked.size() == asked + 3);
}

TEST_CASE("a key in the place of another of the same name is another") {
  ServerOptions options = keyed_options();
  options.keys = with_clients({{"stage", 0x44}});
  ServerBench bench(options);
  NamedPeer stage(bench, 0x44, 40'001);
  stage.shake_hands();
  stage.send();
  bench.server->replace_keys(with_clients({{"stage", 0x45}}), bench.now_ns);
  bench.pass(1);
  CHECK(stage.received().back().has_bye());
}

TEST_CASE("a client of before is told that it is too old, and with what remedy") {
  for (const std::uint8_t role : {kOldViewRole, kOldControlRole}) {
    ServerBench bench(keyed_options());
    KeyedPeer peer(bench, role);
    peer.shake_hands();
    peer.send({acquire_item("peer")});
    const v1::Packet told = peer.client.open(peer.last());
    CHECK(told.reset().reason() == v1::RESET_REASON_OLD_KEY);
    CHECK(told.reset().message().find("hapticctl keygen") != std::string::npos);
    CHECK(told.reset().message().size() <= 400);
    CHECK(bench.server->session_count() == 0);
    CHECK(bench.server->fence() == 0);
    CHECK(bench.server->counters().old_keys == 1);
    const std::size_t sent = bench.sent.size();
    peer.send();
    bench.pass(1000);
    CHECK(bench.sent.size() == sent);
  }
}

TEST_CASE("with the old handshake permitted a client of before is served") {
  ServerOptions options = keyed_options();
  options.old_handshake = true;
  ServerBench bench(options);
  KeyedPeer peer(bench, kOldControlRole);
  peer.shake_hands();
  peer.send({acquire_item("peer")});
  bench.pass(1);
  CHECK(bench.server->session_count() == 1);
  CHECK(bench.server->lease_holder() == "peer");
  CHECK(bench.server->counters().old_keys == 0);
}

TEST_CASE("a session with a key ends with Bye in DATA when the server does") {
  ServerBench bench(keyed_options());
  KeyedPeer peer(bench);
  peer.shake_hands();
  peer.send();
  bench.server->shut_down(v1::BYE_REASON_SHUTDOWN, "the end", bench.now_ns);
  bench.pass(1);
  CHECK(peer.received().back().bye().reason() == v1::BYE_REASON_SHUTDOWN);
  const std::size_t sent = bench.sent.size();
  KeyedPeer late(bench, kControlRole, 40'005, 9);
  bench.receive(late.address, late.client.hello());
  CHECK(bench.sent.size() == sent);
}

}  // namespace
}  // namespace hapticd::test
