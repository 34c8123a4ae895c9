// Equal subscriptions share the work of a tick, and nothing of anybody else's State.
#include "server/network/encoded_states.h"

#include <doctest/doctest.h>

#include "tests/server/network/raw_peer.h"
#include "tests/support/no_heap.h"

namespace hapticd::test {
namespace {

/// A State that says what was asked for, with as many strings as `strings`.
auto telling_fill(int strings) {
  return [strings](const Subscription& subscription, v1::State& state) {
    state.set_t_ns(1000 * state.tick() + subscription.sections);
    state.set_contacts_total(subscription.max_contacts);
    for (int i = 0; i < strings; ++i) {
      v1::StringState& string = *state.add_strings();
      string.set_string_index(static_cast<std::uint32_t>(i));
      string.set_radius_m(0.01F + 1e-5F * static_cast<float>(i));
      for (int k = 0; k < 3; ++k) string.add_deflection_w_m(0.1F);
    }
  };
}

v1::Item subscription(std::uint32_t divisor, std::uint32_t max_contacts) {
  v1::Item item = subscribe_item(divisor);
  item.mutable_subscribe()->set_max_contacts(max_contacts);
  return item;
}

TEST_CASE("sessions with equal subscriptions get equal States, filled in once a tick") {
  for (const int strings : {3, 100}) {  // All of it fits into a datagram; it has to be cut.
    CAPTURE(strings);
    ServerBench bench;
    bench.host.fill = telling_fill(strings);
    std::vector<std::unique_ptr<RawPeer>> peers;
    for (std::uint16_t i = 0; i < 32; ++i) {
      peers.push_back(std::make_unique<RawPeer>(bench, 5, static_cast<std::uint16_t>(40'000 + i)));
      peers.back()->send(subscription(i < 20 ? 1 : 2, i % 4 == 0 ? 7 : 16));
    }
    for (std::uint64_t tick = 0; tick < 10; ++tick) {
      bench.host.subscriptions.clear();
      bench.offer(tick);
      // Divisors 1 and 2, 7 and 16 contacts: each asks for a State of its own.
      CHECK(bench.host.subscriptions.size() == (tick % 2 == 0 ? 4 : 2));
    }
    for (std::size_t i = 0; i < 32; ++i) {
      const std::vector<v1::State> mine = peers[i]->states();
      REQUIRE(mine.size() == (i < 20 ? 10 : 5));
      const std::vector<v1::State> twin = peers[i < 20 ? i % 4 : 20 + i % 4]->states();
      for (std::size_t n = 0; n < mine.size(); ++n) {
        CHECK(mine[n].SerializeAsString() == twin[n].SerializeAsString());
        const std::uint64_t tick = i < 20 ? n : 2 * n;
        CHECK(mine[n].tick() == tick);
        CHECK(mine[n].contacts_total() == (i % 4 == 0 ? 7 : 16));
      }
    }
  }
}

TEST_CASE("sessions with less room get a State cut to their own") {
  EncodedStates states;
  const EncodedStates::Fill fill = telling_fill(60);
  states.begin(4, 1);
  const Subscription wanted{1, 2, 3};
  const auto whole = states.get(wanted, 4000, fill, {});
  const auto roomy = states.get(wanted, 1100, fill, {});
  const auto narrow = states.get(wanted, 500, fill, {});
  REQUIRE(whole->parts.size() == 1);
  REQUIRE(roomy->parts.size() == 1);
  REQUIRE(narrow->parts.size() == 1);
  CHECK(roomy->parts[0].size() <= 1100);
  CHECK(roomy->parts[0].size() > 1000);
  CHECK(narrow->parts[0].size() <= 500);
  v1::State all;
  v1::State cut;
  REQUIRE(all.ParseFromString(whole->parts[0]));
  REQUIRE(cut.ParseFromString(narrow->parts[0]));
  CHECK(all.strings_size() == 60);
  CHECK(!all.has_strings_total());
  CHECK(cut.strings_total() == 60);
  CHECK(states.get(wanted, 500, fill, {}) == narrow);
}

TEST_CASE("another tick, or another scene, is filled in anew") {
  EncodedStates states;
  int filled = 0;
  const EncodedStates::Fill fill = [&](const Subscription&, v1::State&) { ++filled; };
  const Subscription wanted{1, 2, 3};
  const auto state_of = [&](std::uint64_t tick, std::uint32_t scene) {
    states.begin(tick, scene);
    v1::State state;
    REQUIRE(state.ParseFromString(states.get(wanted, 1000, fill, {})->parts.at(0)));
    return state;
  };
  CHECK(state_of(1, 1).tick() == 1);
  CHECK(state_of(2, 1).tick() == 2);
  CHECK(state_of(2, 2).scene_id() == 2);
  CHECK(filled == 3);
}

TEST_CASE("what somebody holds of an earlier tick is not written over") {
  EncodedStates states;
  const EncodedStates::Fill fill = telling_fill(3);
  const Subscription wanted{1, 2, 3};
  std::vector<std::shared_ptr<const EncodedState>> held;
  for (std::uint64_t tick = 0; tick < 5; ++tick) {
    states.begin(tick, 1);
    held.push_back(states.get(wanted, 1000, fill, {}));
  }
  for (std::uint64_t tick = 0; tick < 5; ++tick) {
    v1::State state;
    REQUIRE(state.ParseFromString(held[tick]->parts.at(0)));
    CHECK(state.tick() == tick);
  }
}

TEST_CASE("a State shorter than the one before it carries nothing of that") {
  EncodedStates states;
  const Subscription wanted{1, 2, 3};
  for (const int strings : {7, 2, 5, 0}) {
    states.begin(static_cast<std::uint64_t>(strings), 1);
    v1::State state;
    REQUIRE(state.ParseFromString(states.get(wanted, 1000, telling_fill(strings), {})->parts[0]));
    CHECK(state.strings_size() == strings);
    CHECK(state.SerializeAsString() == states.get(wanted, 1000, {}, {})->parts[0]);
  }
}

TEST_CASE("a tick that is offered to subscribers leaves the heap alone, from State to datagram") {
  std::size_t sent = 0;
  std::size_t bytes = 0;
  RecordingHost recording;
  ServerHost host = recording.functions([](const RequestId&, const v1::Result&) {});
  host.fill_state = telling_fill(7);
  ProtocolServer server({.boot_id = 3}, host,
                        [&](const Address&, std::span<const std::uint8_t> datagram) {
                          ++sent;
                          bytes += datagram.size();
                        });
  const std::int64_t now_ns = 1000 * kTestMs;
  for (std::uint32_t session = 1; session <= 3; ++session) {
    v1::Packet packet;
    packet.set_first(1);
    // Two are alike, the third asks for something else.
    *packet.add_items() = subscription(1, session == 3 ? 7 : 16);
    server.receive(ipv4_address({127, 0, 0, 1}, 40'000), plain_datagram(session, 0, packet),
                   now_ns);
  }
  // What is unacknowledged is repeated in the first of them.
  for (std::uint64_t tick = 1; tick < 4; ++tick) server.offer_tick(tick, 1, now_ns);
  sent = bytes = 0;
  const NoHeapScope scope;
  for (std::uint64_t tick = 4; tick < 8; ++tick) server.offer_tick(tick, 1, now_ns);
  const std::int64_t touched = scope.count();
  CHECK(sent == 12);
  CHECK(bytes > 12 * 150);
  CHECK(touched == 0);
}

}  // namespace
}  // namespace hapticd::test
