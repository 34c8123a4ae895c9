// Which States a session gets, how they thin out, and how far a Run of steps may be ahead.
// PROTOCOL.md, sections 3, 6 and 11.
#include <doctest/doctest.h>

#include "tests/server/network/raw_peer.h"

namespace hapticd::test {
namespace {

std::vector<std::uint64_t> ticks_of(const RawPeer& peer) {
  std::vector<std::uint64_t> ticks;
  for (const v1::State& state : peer.states()) ticks.push_back(state.tick());
  return ticks;
}

using Ticks = std::vector<std::uint64_t>;

/// A Packet that tells of States.
v1::Packet told(std::uint64_t seen, std::uint64_t newest) {
  v1::Packet packet;
  packet.set_seen(seen);
  packet.set_newest(newest);
  return packet;
}

TEST_CASE("a subscriber gets the ticks that are multiples of its divisor, others none") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  RawPeer other(bench, 6, 40'001);
  peer.send(subscribe_item(3));
  other.keep_alive();
  for (std::uint64_t tick = 0; tick < 10; ++tick) bench.offer(tick, 4);
  CHECK(ticks_of(peer) == Ticks{0, 3, 6, 9});
  CHECK(peer.states()[0].scene_id() == 4);
  CHECK(other.states().empty());
  peer.send(subscribe_item(0));
  bench.offer(12);
  CHECK(ticks_of(peer).size() == 4);
}

TEST_CASE(
    "the host is asked for the sections of the subscription; without any for the usual three") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  v1::Item item = subscribe_item(1);
  item.mutable_subscribe()->add_sections(v1::SECTION_TIMING);
  item.mutable_subscribe()->mutable_sections()->Add(999);  // Of a later version.
  item.mutable_subscribe()->set_max_contacts(3);
  peer.send(item);
  bench.offer(0);
  peer.send(subscribe_item(1));
  bench.offer(1);
  REQUIRE(bench.host.subscriptions.size() == 2);
  CHECK(bench.host.subscriptions[0].sections == 1U << v1::SECTION_TIMING);
  CHECK(bench.host.subscriptions[0].max_contacts == 3);
  CHECK(bench.host.subscriptions[1].has(v1::SECTION_TOOLS));
  CHECK(bench.host.subscriptions[1].has(v1::SECTION_STRINGS));
  CHECK(bench.host.subscriptions[1].has(v1::SECTION_CONTACTS));
  CHECK(!bench.host.subscriptions[1].has(v1::SECTION_TIMING));
  CHECK(bench.host.subscriptions[1].max_contacts == 16);
}

TEST_CASE("after 3 s of silence a State leaves per 100 ms, after a word all of them again") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  peer.send(subscribe_item(1));
  std::uint64_t tick = 0;
  const auto run = [&](std::int64_t ms) {
    const std::size_t before = peer.states().size();
    for (std::int64_t i = 0; i < ms; ++i) {
      bench.pass(1);
      bench.offer(tick++);
    }
    return peer.states().size() - before;
  };
  CHECK(run(2900) == 2900);
  run(200);
  CHECK(run(1000) == 10);
  peer.keep_alive();
  CHECK(run(500) == 500);
}

/// A second of States at 1 kHz to a peer that receives a share of them and tells so every 100 ms.
/// States sent.
std::size_t second_with_loss(ServerBench& bench, RawPeer& peer, std::uint64_t& tick, double loss,
                             double& seen) {
  std::size_t sent = 0;
  for (int i = 0; i < 1000; ++i) {
    bench.pass(1);
    const std::size_t before = bench.sent.size();
    bench.offer(tick++);
    const std::size_t states = bench.sent.size() - before;
    sent += states;
    seen += static_cast<double>(states) * (1.0 - loss);
    if (i % 100 == 99) peer.keep_alive(told(static_cast<std::uint64_t>(seen), tick));
  }
  bench.sent.clear();
  return sent;
}

TEST_CASE("more than 10 % of loss doubles the divisor second by second, less than 1 % halves it") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  peer.send(subscribe_item(1));
  std::uint64_t tick = 0;
  double seen = 0.0;
  second_with_loss(bench, peer, tick, 0.0, seen);
  CHECK(second_with_loss(bench, peer, tick, 0.05, seen) == 1000);
  second_with_loss(bench, peer, tick, 0.3, seen);
  second_with_loss(bench, peer, tick, 0.3, seen);
  const std::size_t thinned = second_with_loss(bench, peer, tick, 0.05, seen);
  CHECK(thinned <= 500);
  CHECK(thinned >= 125);
  for (int i = 0; i < 5; ++i) second_with_loss(bench, peer, tick, 0.0, seen);
  CHECK(second_with_loss(bench, peer, tick, 0.0, seen) == 1000);
}

TEST_CASE("in lockstep no loss thins anything") {
  ServerBench bench({.boot_id = 1, .virtual_clock = true});
  RawPeer peer(bench, 5);
  peer.send(subscribe_item(1));
  std::uint64_t tick = 0;
  double seen = 0.0;
  for (int i = 0; i < 4; ++i) CHECK(second_with_loss(bench, peer, tick, 0.5, seen) == 1000);
}

struct Lockstep {
  ServerBench bench{{.boot_id = 1, .virtual_clock = true}};
  RawPeer peer{bench, 5};
  std::uint64_t tick = 0;

  explicit Lockstep(std::uint32_t divisor) {
    peer.send({acquire_item("peer"), subscribe_item(divisor)});
    bench.host.answers = false;
    peer.send(run_item(v1::RUN_MODE_STEP, 10'000));
  }
  /// Ticks taken until the server wants no more, `most` at most.
  std::uint64_t steps(std::uint64_t most = 5000) {
    std::uint64_t taken = 0;
    while (taken < most && bench.server->may_step(bench.now_ns)) {
      bench.offer(tick++);
      ++taken;
    }
    return taken;
  }
};

TEST_CASE("a Run of steps is at most 64 States ahead of what its session has told of") {
  Lockstep session(1);
  CHECK(session.steps() == 64);
  session.peer.keep_alive(told(10, 9));
  CHECK(session.steps() == 10);
  session.peer.keep_alive(told(74, 73));
  CHECK(session.steps() == 64);
}

TEST_CASE("with a divisor 64 States are that many ticks; without a subscription nothing waits") {
  Lockstep session(10);
  CHECK(session.steps() == 631);  // Ticks 0, 10, ... 630 were sent.
  session.peer.keep_alive(told(64, 630));
  CHECK(session.steps() == 640);
  Lockstep other(0);
  CHECK(other.steps(3000) == 3000);
}

TEST_CASE("a viewer does not hold up the Run of another session") {
  Lockstep session(0);
  RawPeer viewer(session.bench, 6, 40'001);
  viewer.send(subscribe_item(1));
  CHECK(session.steps(3000) == 3000);
}

TEST_CASE("a Run that waits repeats the newest State every 50 ms, and goes on when told") {
  Lockstep session(1);
  session.steps();
  session.bench.sent.clear();
  session.bench.pass(200);
  CHECK(ticks_of(session.peer) == Ticks{63, 63, 63, 63});
  session.peer.keep_alive(told(2, 63));
  CHECK(session.steps() == 64);
}

TEST_CASE("a Run waits no longer when its session has ended") {
  Lockstep session(1);
  session.steps();
  CHECK(!session.bench.server->may_step(session.bench.now_ns));
  session.peer.send(bye_item());
  CHECK(session.bench.server->may_step(session.bench.now_ns));
  CHECK(session.bench.host.abandoned.size() == 1);
}

TEST_CASE("what was told of the scene before does not count for the next one") {
  Lockstep session(1);
  session.steps();
  session.peer.keep_alive(told(64, 63));
  session.steps(64);
  session.peer.keep_alive(told(128, 127));
  for (std::uint64_t tick = 0; tick < 64; ++tick) session.bench.offer(tick, 2);
  CHECK(!session.bench.server->may_step(session.bench.now_ns));
  session.peer.keep_alive(told(128, 127));
  CHECK(!session.bench.server->may_step(session.bench.now_ns));
  session.peer.keep_alive(told(192, 63));
  CHECK(session.bench.server->may_step(session.bench.now_ns));
}

TEST_CASE("a State too large for one datagram is cut to size") {
  ServerBench bench;
  v1::SceneInfo& scene = *bench.host.greeting[0].mutable_scene_info();
  for (int i = 0; i < 100; ++i)
    scene.mutable_scene()->add_strings()->set_radius_m(i == 7 ? 0.0 : 0.01);
  RawPeer peer(bench, 5);
  peer.send(subscribe_item(1));
  bench.host.fill = [](const Subscription&, v1::State& state) {
    for (std::uint32_t i = 0; i < 100; ++i) {
      v1::StringState& string = *state.add_strings();
      string.set_string_index(i);
      string.set_radius_m(0.0101F);
      for (int k = 0; k < 3; ++k) string.add_deflection_w_m(0.1F);
    }
  };
  bench.offer(0);
  REQUIRE(peer.states().size() == 1);
  const v1::State state = peer.states()[0];
  CHECK(state.strings_total() == 100);
  CHECK(state.strings_size() > 20);
  // String 7 has grown most, by the radii of SceneInfo.
  bool has_seven = false;
  for (const v1::StringState& string : state.strings()) {
    has_seven = has_seven || string.string_index() == 7;
  }
  CHECK(has_seven);
  CHECK(peer.received().back().bytes <= 1200 - 16);
}

}  // namespace
}  // namespace hapticd::test
