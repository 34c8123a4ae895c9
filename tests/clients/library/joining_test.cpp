// How long joining, failing over and coming back take. PROTOCOL.md, sections 3, 4 and 9; virtual
// clock, real server and clients.
#include <doctest/doctest.h>

#include "tests/clients/library/virtual_network.h"

namespace hapticd::test {
namespace {

v1::Item subscribe_item(std::uint32_t divisor) {
  v1::Item item;
  item.mutable_subscribe()->set_divisor(divisor);
  return item;
}

v1::Item acquire_item(const std::string& holder) {
  v1::Item item;
  item.mutable_acquire()->set_holder(holder);
  return item;
}

bool has_greeting(const VirtualClient& mine) {
  return mine.items.size() >= 3 && mine.items[0].has_scene_info() &&
         mine.items[1].has_lease_info() && mine.items[2].has_record_info();
}

TEST_CASE("who joins late knows everything within two round trips and a period") {
  for (const std::int64_t delay_ms : {0, 1, 5, 20, 80}) {
    CAPTURE(delay_ms);
    VirtualNetwork network;
    network.tick_each_step = true;
    VirtualClient& early = network.add_client();
    early.core->request(acquire_item("early"));
    network.run_for(5 * kTestSecond_ns);
    LinkConditions conditions;
    conditions.delay_ns = delay_ms * kTestMillisecond_ns;
    VirtualClient& late = network.add_client(conditions, 4);
    constexpr std::uint32_t kDivisor = 10;  // A period of 5 ms: the network ticks at 2 kHz.
    late.core->request(subscribe_item(kDivisor));
    const std::int64_t begun_ns = network.now_ns;
    REQUIRE(network.run_until(kTestSecond_ns,
                              [&] { return has_greeting(late) && !late.states.empty(); }));
    const std::int64_t period_ns = std::int64_t{kDivisor} * 500'000;
    const std::int64_t polls_ns =
        4 * std::int64_t{500'000};  // Each hop waits for the next step of this test.
    CHECK(network.now_ns - begun_ns <= 4 * delay_ms * kTestMillisecond_ns + period_ns + polls_ns);
    CHECK(late.items[1].lease_info().holder() == "early");
  }
}

TEST_CASE("when the controller vanishes another one has the lease within 2.5 s") {
  VirtualNetwork network;
  LinkConditions conditions;
  conditions.delay_ns = 5 * kTestMillisecond_ns;
  VirtualClient& first = network.add_client(conditions, 1);
  VirtualClient& second = network.add_client(conditions, 9);
  first.core->request(acquire_item("first"));
  network.run_for(kTestSecond_ns);
  CHECK(network.server->lease_holder() == "first");
  first.to_server.set_blackhole(true);
  const std::int64_t vanished_ns = network.now_ns;
  std::size_t heard = second.items.size();
  REQUIRE(network.run_until(5 * kTestSecond_ns, [&] {
    for (; heard < second.items.size(); ++heard) {
      if (second.items[heard].has_lease_info() && second.items[heard].lease_info().fence() == 0) {
        second.core->request(acquire_item("second"));
      }
    }
    return network.server->lease_holder() == "second";
  }));
  CHECK(network.now_ns - vanished_ns <= 2500 * kTestMillisecond_ns);
  REQUIRE(network.host.lease_ends.size() == 1);
  CHECK(network.host.lease_ends[0] == LeaseEnd::kExpired);
  // The first one comes back and knows that it controls no more.
  first.to_server.set_blackhole(false);
  network.run_for(kTestSecond_ns);
  CHECK(first.items.back().lease_info().holder() == "second");
  CHECK(!first.items.back().lease_info().yours());
}

TEST_CASE("a session survives 9 s in a black hole, and nothing of it is lost") {
  VirtualNetwork network;
  VirtualClient& mine = network.add_client();
  network.run_for(kTestSecond_ns);
  mine.to_server.set_blackhole(true);
  mine.to_client.set_blackhole(true);
  for (std::uint32_t i = 0; i < 500; ++i) network.server->broadcast(tone_item(i));
  network.run_for(9 * kTestSecond_ns);
  mine.to_server.set_blackhole(false);
  mine.to_client.set_blackhole(false);
  CHECK(network.run_until(2 * kTestSecond_ns, [&] { return mine.tones().size() == 500; }));
  CHECK(mine.ends.empty());
}

TEST_CASE("after 11 s in a black hole a session begins anew, with the same subscription") {
  VirtualNetwork network;
  VirtualClient& mine = network.add_client();
  mine.core->request(subscribe_item(1));
  network.run_for(kTestSecond_ns);
  const std::uint32_t before = mine.core->session();
  bool told = false;
  mine.to_client.set_blackhole(true);
  mine.to_server.set_blackhole(true);
  mine.core->request(numbered_request(1), [&](const v1::Result* r) { told = r == nullptr; });
  network.run_for(11 * kTestSecond_ns);
  CHECK(network.server->session_count() == 0);
  mine.to_client.set_blackhole(false);
  mine.to_server.set_blackhole(false);
  network.tick_each_step = true;
  CHECK(network.run_until(2 * kTestSecond_ns,
                          [&] { return has_greeting(mine) && !mine.states.empty(); }));
  REQUIRE(mine.ends.size() == 1);
  CHECK(mine.ends[0] == client::SessionEnd::kSilence);
  CHECK(mine.core->session() != before);
  CHECK(told);
}

TEST_CASE("thirty-two clients are served, and the thirty-third when one has left") {
  VirtualNetwork network;
  // Who only looks may have to give way.
  v1::Item stop;
  stop.mutable_stop();
  for (std::uint64_t i = 0; i < 33; ++i) network.add_client({}, 1000 * i).core->request(stop);
  network.run_for(kTestSecond_ns);
  CHECK(network.server->session_count() == 32);
  std::size_t served = 0;
  for (const auto& each : network.clients) served += has_greeting(*each) ? 1U : 0U;
  CHECK(served == 32);
  CHECK(!network.clients[32]->ends.empty());
  CHECK(network.clients[32]->ends.back() == client::SessionEnd::kFull);
  network.clients[4]->core->leave(network.clients[4]->own_ns(network.now_ns));
  CHECK(network.run_until(2 * kTestSecond_ns, [&] { return has_greeting(*network.clients[32]); }));
  CHECK(network.clients[4]->core->over());
  REQUIRE(network.clients[4]->ends.size() == 1);
  CHECK(network.clients[4]->ends[0] == client::SessionEnd::kLeft);
}

TEST_CASE("a client dismissed by the server waits a second and begins anew") {
  VirtualNetwork network;
  VirtualClient& mine = network.add_client();
  network.run_for(kTestSecond_ns);
  network.server->shut_down(v1::BYE_REASON_SHUTDOWN, "later", network.now_ns);
  CHECK(network.run_until(kTestSecond_ns, [&] { return !mine.ends.empty(); }));
  CHECK(mine.ends[0] == client::SessionEnd::kBye);
  CHECK(mine.core->request(numbered_request(1)) == 0);
  network.start_server({.boot_id = 8});
  CHECK(network.run_until(3 * kTestSecond_ns, [&] { return has_greeting(mine); }));
  CHECK(mine.core->boot_id() == 8);
}

TEST_CASE("a client that nobody answers ends its session with 1024 Items") {
  VirtualNetwork network;
  VirtualClient& mine = network.add_client();
  mine.to_server.set_blackhole(true);
  for (std::uint64_t i = 0; i < 1024; ++i) CHECK(mine.core->request(numbered_request(i)) == i + 1);
  int lost = 0;
  CHECK(mine.core->request(numbered_request(9), [&](const v1::Result*) { ++lost; }) == 0);
  REQUIRE(mine.ends.size() == 1);
  CHECK(mine.ends[0] == client::SessionEnd::kBacklog);
  CHECK(lost == 0);
}

}  // namespace
}  // namespace hapticd::test
