// Keyed sessions of real clients and a real server over a virtual network: what holds for PLAIN
// holds for them, and nobody without the key changes anything. PROTOCOL.md, sections 2 to 4 and 12.
#include <doctest/doctest.h>

#include "tests/clients/library/captured_session.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// Numbers of the requests the host was asked, in order.
std::vector<std::uint32_t> asked_numbers(const VirtualNetwork& network) {
  std::vector<std::uint32_t> numbers;
  numbers.reserve(network.host.asked.size());
  for (const RecordingHost::Asked& each : network.host.asked) {
    numbers.push_back(static_cast<std::uint32_t>(std::stoul(each.item.get_parameters().paths(0))));
  }
  return numbers;
}

/// Who is on the way: sends what it heard again, damaged, from elsewhere.
struct Attacker {
  VirtualNetwork& network;
  VirtualClient& victim;
  SplitMix64 random;

  void act() {
    const std::vector<Datagram>& out = victim.captured;
    const std::vector<Datagram>& in = victim.captured_from_server;
    if (!out.empty()) {
      Datagram datagram = out[random.below(out.size())];
      if (random.chance(0.7)) change(datagram);
      Address from = victim.address;
      if (random.chance(0.3)) from.port = static_cast<std::uint16_t>(1 + random.below(60'000));
      network.server->receive(from, datagram, network.now_ns);
    }
    if (!in.empty()) {
      Datagram datagram = in[random.below(in.size())];
      if (random.chance(0.7)) change(datagram);
      victim.core->receive(datagram, victim.own_ns(network.now_ns));
    }
  }

 private:
  void change(Datagram& datagram) {
    if (random.chance(0.2)) datagram.resize(random.below(datagram.size() + 1));
    for (std::uint64_t i = random.below(3); i > 0 && !datagram.empty(); --i) {
      datagram[random.below(datagram.size())] ^= static_cast<std::uint8_t>(1U << random.below(8));
    }
    // A counter of its own choice, as if it were new.
    if (random.chance(0.3) && datagram.size() > 16)
      datagram[8] = static_cast<std::uint8_t>(random.next());
  }
};

TEST_CASE("keyed Items arrive exactly once and in order, whatever the network and an attacker do") {
  const std::int64_t schedules = scaled(2000);
  SplitMix64 random(31);
  for (std::int64_t schedule = 0; schedule < schedules; ++schedule) {
    CAPTURE(schedule);
    VirtualNetwork network(keyed_network(7, random.next()));
    LinkConditions conditions = bad_conditions(random);
    conditions.damage = random.uniform(0.0, 0.2);  // The tag finds what it does.
    VirtualClient& mine = network.add_client(conditions, random.next(), control_key());
    network.capturing = true;
    Attacker attacker{network, mine, SplitMix64(random.next())};
    const double attacks = random.uniform(0.0, 1.0);
    const auto attacked = [&](bool done) {
      if (random.chance(attacks)) attacker.act();
      return done;
    };
    REQUIRE(network.run_until(20 * kTestSecond_ns,
                              [&] { return attacked(network.server->session_count() == 1); }));
    // Who floods HELLOs in its name can keep a client waiting until its WELCOME is too old.
    mine.ends.clear();
    std::vector<std::uint64_t> sent_ids;
    std::vector<std::uint64_t> answered_ids;
    constexpr std::size_t kCount = 20;
    std::size_t told = 0;
    const auto step = [&] {
      if (told < kCount) network.server->broadcast(tone_item(static_cast<std::uint32_t>(told++)));
      if (sent_ids.size() < kCount) {
        sent_ids.push_back(
            mine.core->request(numbered_request(sent_ids.size()), [&](const v1::Result* r) {
              if (r != nullptr) answered_ids.push_back(r->item_id());
            }));
      }
      return attacked(mine.tones().size() >= kCount && answered_ids.size() >= kCount);
    };
    REQUIRE(network.run_until(60 * kTestSecond_ns, step));
    network.run_until(100 * kTestMillisecond_ns, [&] { return attacked(false); });
    CHECK(mine.tones() == up_to(kCount));
    CHECK(asked_numbers(network) == up_to(kCount));
    CHECK(answered_ids == sent_ids);
    CHECK(mine.ends.empty());
    CHECK(network.server->session_count() == 1);
    CHECK(network.server->counters().protocol_errors == 0);
  }
}

/// Datagrams that the server took as a session's.
std::uint64_t taken(const VirtualNetwork& network) {
  const ServerCounters& c = network.server->counters();
  const HelloCounters& h = c.hellos;
  const std::uint64_t hellos =
      h.retried + h.welcomed + h.repeated + h.malformed + h.forged + h.limited + h.full;
  return c.received - c.bad_header - c.unknown_session - c.repeated - c.unreadable - c.forged -
         hellos;
}

TEST_CASE("of every datagram captured, sent again to either side, none is accepted") {
  CapturedSession session(keyed_network(), control_key());
  VirtualNetwork& network = session.network;
  VirtualClient& mine = *session.mine;
  CHECK(mine.captured.size() > 100);
  CHECK(mine.captured_from_server.size() > 100);
  const auto asked = asked_numbers(network);
  const std::size_t items = mine.items.size();
  std::uint64_t accepted = 0;
  for (const Datagram& datagram : mine.captured) {
    const std::uint64_t before = taken(network);
    const std::size_t was_asked = network.host.asked.size();
    network.server->receive(mine.address, datagram, network.now_ns);
    // One that was lost the first time is no repetition: it may be taken, once, and says nothing
    // new.
    accepted += taken(network) != before && network.host.asked.size() != was_asked ? 1U : 0U;
  }
  const std::uint64_t all_taken = taken(network);
  for (const Datagram& datagram : mine.captured) {
    network.server->receive(mine.address, datagram, network.now_ns);
    network.server->receive(ipv4_address({127, 0, 0, 9}, 50'000), datagram, network.now_ns);
  }
  CHECK(taken(network) == all_taken);
  for (const Datagram& datagram : mine.captured_from_server) {
    mine.core->receive(datagram, mine.own_ns(network.now_ns));
  }
  CHECK(accepted == 0);
  CHECK(asked_numbers(network) == asked);
  CHECK(mine.items.size() == items);
  CHECK(mine.ends.empty());
  CHECK(network.server->lease_holder() == "mine");
  CHECK(network.server->session_count() == 1);
}

TEST_CASE("nobody opens a session with a key the server does not have, or under the other role") {
  VirtualNetwork network(keyed_network());
  client::ClientKey wrong = control_key();
  wrong.psk = even_key(0x23);
  VirtualClient& foreign = network.add_client({}, 1, wrong);
  VirtualClient& climber = network.add_client(
      {}, 2, client::ClientKey{wire::Role::kControl, even_key(0x11), network_keys().server});
  VirtualClient& plain = network.add_client({}, 3);
  network.run_for(5 * kTestSecond_ns);
  CHECK(network.server->session_count() == 0);
  CHECK(network.server->counters().sent == 0);
  for (const VirtualClient* each : {&foreign, &climber, &plain}) CHECK(!each->core->heard());
}

TEST_CASE("a keyed client that hears nothing for 3 s says HELLO again, and joins a new server") {
  VirtualNetwork network(keyed_network(7));
  VirtualClient& mine = network.add_client({}, 1, control_key());
  network.run_for(kTestSecond_ns);
  CHECK(mine.core->boot_id() == 7);
  const std::uint32_t before = mine.core->session();
  network.start_server(keyed_network(8, 2));
  CHECK(network.run_until(4 * kTestSecond_ns, [&] { return mine.core->boot_id() == 8; }));
  REQUIRE(mine.ends.size() == 1);
  CHECK(mine.ends[0] == client::SessionEnd::kSilence);
  CHECK(mine.core->session() != before);
}

TEST_CASE("requests made before the session is open are carried out when it is") {
  VirtualNetwork network(keyed_network());
  LinkConditions conditions;
  conditions.delay_ns = 20 * kTestMillisecond_ns;
  VirtualClient& mine = network.add_client(conditions, 1, control_key());
  bool answered = false;
  mine.core->request(numbered_request(0), [&](const v1::Result* r) { answered = r != nullptr; });
  CHECK(mine.core->session() == 0);
  // HELLO, RETRY, HELLO, WELCOME, DATA, Result: three round trips.
  CHECK(network.run_until(130 * kTestMillisecond_ns, [&] { return answered; }));
}

TEST_CASE("a client that leaves before anybody has answered is done in a second") {
  VirtualNetwork network;
  VirtualClient& mine = network.add_client({}, 1, control_key());
  network.run_for(100 * kTestMillisecond_ns);
  mine.core->leave(mine.own_ns(network.now_ns));
  CHECK(network.run_until(1001 * kTestMillisecond_ns, [&] { return mine.core->over(); }));
}

}  // namespace
}  // namespace hapticd::test
