// A Stop waits for no request that costs much: those of all sessions are carried out one at a time,
// between two looks at the socket, and those that look at files once in 10 ms of a session.
// PROTOCOL.md, section 8. What a request costs is counted by the host, in virtual time.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "tests/server/network/keyed_peer.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

v1::Item listing_item(std::uint64_t which) {
  v1::Item item;
  if (which % 3 == 0) item.mutable_list_scenes();
  if (which % 3 == 1) item.mutable_list_gestures();
  if (which % 3 == 2) item.mutable_list_recordings();
  return item;
}

v1::Item reading_item(std::uint64_t which) {
  v1::Item item;
  if (which % 2 == 0) item.mutable_get_parameters();
  if (which % 2 == 1) item.mutable_get_device_info();
  return item;
}

bool looks_at_files(const v1::Item& item) {
  return item.has_list_scenes() || item.has_list_gestures() || item.has_list_recordings();
}

/// One call of the host.
struct Call {
  std::int64_t at_ns = 0;
  int poll = 0;  ///< how many polls had begun
  RequestId id;
  v1::Item item;
};

/// A bench whose host tells when it was called.
struct Watched {
  ServerBench bench;
  std::vector<Call> calls;
  int polls = 0;

  /// Half a millisecond: the socket has been emptied, the server is polled.
  void turn() {
    bench.now_ns += kTestMs / 2;
    const std::size_t before = bench.host.asked.size();
    ++polls;
    bench.server->poll(bench.now_ns);
    note(before);
  }
  /// What `peer` says is received; what the host was asked meanwhile belongs to no poll.
  void say(RawPeer& peer, const std::vector<v1::Item>& items) {
    const std::size_t before = bench.host.asked.size();
    peer.send(items);
    note(before);
  }
  void note(std::size_t from) {
    for (std::size_t i = from; i < bench.host.asked.size(); ++i) {
      calls.push_back({bench.now_ns, polls, bench.host.asked[i].id, bench.host.asked[i].item});
    }
  }
};

}  // namespace

TEST_CASE("a Stop is obeyed where it arrives, however much other sessions ask for") {
  Watched watched;
  std::vector<std::unique_ptr<RawPeer>> peers;
  peers.reserve(31);
  for (std::uint16_t i = 0; i < 31; ++i) {
    peers.push_back(
        std::make_unique<RawPeer>(watched.bench, 5, static_cast<std::uint16_t>(40'000 + i)));
  }
  RawPeer operating(watched.bench, 7, 45'000);
  watched.say(operating, {ping_item()});
  SplitMix64 random(11);
  // Enough for some of them to have a Stop.
  const std::int64_t rounds = std::max<std::int64_t>(scaled(400), 40);
  std::int64_t stops = 0;
  for (std::int64_t round = 0; round < rounds; ++round) {
    for (const auto& peer : peers) {
      if (random.chance(0.5)) continue;
      std::vector<v1::Item> items;
      items.reserve(16);
      for (int k = 0; k < 16; ++k) {
        items.push_back(random.chance(0.7) ? listing_item(random.next())
                                           : reading_item(random.next()));
      }
      watched.say(*peer, items);
    }
    if (random.chance(0.2)) {
      const std::size_t before = watched.calls.size();
      watched.say(operating, {stop_item()});
      ++stops;
      // At once: between its arrival and the host nothing else was done.
      REQUIRE(watched.calls.size() == before + 1);
      CHECK(watched.calls.back().item.has_stop());
    }
    watched.turn();
  }
  CHECK(stops > 0);
  // Between two looks at the socket no more than one request that costs much.
  std::map<int, int> in_poll;
  std::size_t costly = 0;
  for (const Call& call : watched.calls) {
    if (call.item.has_stop()) continue;
    ++costly;
    CHECK(++in_poll[call.poll] == 1);
  }
  CHECK(costly > 0);
}

TEST_CASE("a Stop overtakes the requests of its own session that cost much") {
  Watched watched;
  RawPeer peer(watched.bench, 5);
  watched.say(peer, {listing_item(0), listing_item(1), reading_item(0), stop_item()});
  REQUIRE(watched.calls.size() == 1);
  CHECK(watched.calls[0].item.has_stop());
}

TEST_CASE(
    "requests that look at files are carried out once in 10 ms of a session, all and in order") {
  Watched watched;
  std::vector<std::unique_ptr<RawPeer>> peers;
  SplitMix64 random(12);
  std::map<std::uint64_t, std::vector<std::string>> wanted;  // by session's serial number
  for (std::uint16_t i = 0; i < 24; ++i) {
    peers.push_back(
        std::make_unique<RawPeer>(watched.bench, 5, static_cast<std::uint16_t>(40'000 + i)));
    std::vector<v1::Item> items;
    for (int k = 0; k < 12; ++k) {
      items.push_back(random.chance(0.6) ? listing_item(random.next())
                                         : reading_item(random.next()));
      wanted[i + 1U].push_back(items.back().SerializeAsString());
    }
    watched.say(*peers.back(), items);
  }
  for (int i = 0; i < 2 * 250; ++i) {
    watched.turn();
    if (i % 20 == 0) {
      for (const auto& peer : peers) peer->keep_alive();
    }
  }
  std::map<std::uint64_t, std::vector<std::string>> got;
  std::map<std::uint64_t, std::int64_t> last_ns;
  for (const Call& call : watched.calls) {
    got[call.id.session].push_back(call.item.SerializeAsString());
    if (!looks_at_files(call.item)) continue;
    const auto known = last_ns.find(call.id.session);
    if (known != last_ns.end()) CHECK(call.at_ns - known->second >= 10 * kTestMs);
    last_ns[call.id.session] = call.at_ns;
  }
  CHECK(got == wanted);
  for (const auto& peer : peers) {
    for (std::uint64_t id = 1; id <= 12; ++id) CHECK(peer->code(id) == v1::RESULT_CODE_OK);
  }
}

TEST_CASE("sessions take turns: who asks for little waits for one request of each other") {
  Watched watched;
  std::vector<std::unique_ptr<RawPeer>> peers;
  for (std::uint16_t i = 0; i < 20; ++i) {
    peers.push_back(
        std::make_unique<RawPeer>(watched.bench, 5, static_cast<std::uint16_t>(40'000 + i)));
    for (int k = 0; k < 8; ++k) {
      watched.say(*peers.back(), std::vector<v1::Item>(16, reading_item(0)));
    }
  }
  for (int i = 0; i < 30; ++i) watched.turn();
  RawPeer modest(watched.bench, 6, 45'000);
  watched.say(modest, {reading_item(1)});
  for (int i = 0; i < 21; ++i) watched.turn();
  CHECK(modest.code(1) == v1::RESULT_CODE_OK);
}

TEST_CASE(
    "requests that cost much take no more than a tenth of the time of a session, and a quarter of "
    "an address; the holder of the lease waits for no budget") {
  std::int64_t worked_ns = 0;
  ServerOptions options{.boot_id = 0xc0ffee};
  options.work_time = [&] { return worked_ns; };
  ServerBench bench(options);
  SplitMix64 random(13);
  // One that holds the lease, one of another address, and three that share one.
  std::vector<std::unique_ptr<RawPeer>> peers;
  for (std::uint16_t i = 0; i < 5; ++i) {
    const auto last = static_cast<std::uint8_t>(i < 2 ? i + 1 : 9);
    const auto port = static_cast<std::uint16_t>(40'000 + i);
    peers.push_back(std::make_unique<RawPeer>(bench, 5, ipv4_address({10, 0, 0, last}, port)));
    peers[i]->keep_alive();
  }
  peers[0]->send(acquire_item("holder"));
  std::map<std::uint64_t, std::int64_t> taken_ns;  // by session's serial number, from 1
  std::size_t known = bench.host.asked.size();
  constexpr std::int64_t kSeconds = 2;
  std::int64_t dearest_ns = 0;
  for (std::int64_t turn = 0; turn < 2000 * kSeconds; ++turn) {
    if (turn % 20 == 0) {
      for (const auto& peer : peers) peer->send(std::vector<v1::Item>(8, reading_item(0)));
    }
    bench.now_ns += kTestMs / 2;
    // Between 20 us and 2 ms each; what it is the server cannot know before.
    const auto cost_ns =
        static_cast<std::int64_t>(20e3 * std::pow(100.0, random.uniform(0.0, 1.0)));
    bench.host.works = [&] { worked_ns += cost_ns; };
    bench.server->poll(bench.now_ns);
    for (; known < bench.host.asked.size(); ++known) {
      taken_ns[bench.host.asked[known].id.session] += cost_ns;
      dearest_ns = std::max(dearest_ns, cost_ns);
    }
  }
  REQUIRE(taken_ns.size() == 5);
  const double whole_ns = 1e9 * kSeconds;
  const double edge_ns = static_cast<double>(kTimeSlice_ns + dearest_ns);
  for (std::uint64_t serial = 2; serial <= 5; ++serial) {
    CHECK(static_cast<double>(taken_ns[serial]) <= whole_ns / 10 + edge_ns);
  }
  const std::int64_t shared_ns = taken_ns[3] + taken_ns[4] + taken_ns[5];
  CHECK(static_cast<double>(shared_ns) <= whole_ns / 4 + edge_ns);
  // They had what they may have, or nearly.
  CHECK(static_cast<double>(shared_ns) >= 0.8 * whole_ns / 4);
  CHECK(static_cast<double>(taken_ns[2]) >= 0.8 * whole_ns / 10);
  CHECK(taken_ns[1] > 2 * taken_ns[2]);
}

TEST_CASE("what costs little does not wait for what costs much of another session") {
  Watched watched;
  RawPeer listing(watched.bench, 5);
  RawPeer other(watched.bench, 6, 40'001);
  watched.say(listing, std::vector<v1::Item>(16, listing_item(1)));
  watched.say(other, {ping_item(), acquire_item("other"), engage_item()});
  CHECK(watched.calls.size() == 1);
  CHECK(watched.calls[0].item.has_engage());
}

TEST_CASE("a request without the right or the lease is refused at once, whatever it would cost") {
  ServerBench bench(keyed_options());
  KeyedPeer peer(bench, kViewRole);
  peer.shake_hands();
  std::vector<v1::Item> items(3);
  items[0].mutable_set_parameter();
  items[1].mutable_play_gesture();
  items[2].mutable_record();
  peer.send(items);
  bench.pass(1);
  for (std::uint64_t id = 1; id <= 3; ++id) {
    CHECK(peer.code(id) == v1::RESULT_CODE_NOT_PERMITTED);
  }
  CHECK(bench.host.asked.empty());
}

}  // namespace hapticd::test
