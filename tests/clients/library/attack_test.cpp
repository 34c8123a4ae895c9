// Datagrams that come again, from elsewhere, or damaged. PROTOCOL.md, sections 2 and 3. Damage that
// the checksum of UDP would have caught reaches both sides here.
#include <doctest/doctest.h>

#include "tests/clients/library/captured_session.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

TEST_CASE("every datagram of a session sent to the server again changes nothing") {
  CapturedSession session;
  VirtualNetwork& network = session.network;
  const std::size_t asked = network.host.asked.size();
  const std::uint64_t taken = network.server->counters().repeated;
  CHECK(session.mine->captured.size() > 100);
  for (const Datagram& datagram : session.mine->captured) {
    network.server->receive(session.mine->address, datagram, network.now_ns);
  }
  CHECK(network.host.asked.size() == asked);
  CHECK(asked == 100);
  // All but those that had been lost, and so had never been seen.
  CHECK(network.server->counters().repeated - taken > session.mine->captured.size() * 3 / 4);
  network.run_for(kTestSecond_ns);
  CHECK(network.server->session_count() == 1);
  CHECK(session.mine->ends.empty());
}

TEST_CASE("every datagram of a session sent to the client again changes nothing") {
  CapturedSession session;
  VirtualClient& mine = *session.mine;
  const std::size_t items = mine.items.size();
  const std::size_t states = mine.states.size();
  CHECK(states > 10);
  CHECK(mine.captured_from_server.size() > 100);
  for (const Datagram& datagram : mine.captured_from_server) {
    mine.core->receive(datagram, mine.own_ns(session.network.now_ns));
  }
  CHECK(mine.items.size() == items);
  CHECK(mine.states.size() == states);
  CHECK(mine.ends.empty());
}

TEST_CASE("datagrams of a session sent from another address do not touch it") {
  CapturedSession session;
  VirtualNetwork& network = session.network;
  const Address elsewhere = ipv4_address({127, 0, 0, 2}, 50'000);
  for (const Datagram& datagram : session.mine->captured) {
    network.server->receive(elsewhere, datagram, network.now_ns);
  }
  CHECK(network.server->lease_holder() == "mine");
  CHECK(network.server->fence() == 1);
  const std::size_t tones = session.mine->tones().size();
  network.server->broadcast(tone_item(100));
  network.run_for(kTestSecond_ns);
  CHECK(session.mine->tones().size() == tones + 1);
  CHECK(session.mine->ends.empty());
}

TEST_CASE("a Reset for another session, or one of an earlier session, is not obeyed") {
  CapturedSession session;
  VirtualClient& mine = *session.mine;
  v1::Packet reset;
  reset.set_first(1);
  reset.set_boot_id(99);
  reset.mutable_reset()->set_reason(v1::RESET_REASON_UNKNOWN_SESSION);
  const auto header =
      wire::encode_header({wire::DatagramKind::kPlain, mine.core->session() + 1, 0});
  Datagram datagram(header.begin(), header.end());
  const std::string body = reset.SerializeAsString();
  datagram.insert(datagram.end(), body.begin(), body.end());
  mine.core->receive(datagram, mine.own_ns(session.network.now_ns));
  CHECK(mine.ends.empty());
}

TEST_CASE("damaged datagrams crash nobody, and the next session works") {
  const std::int64_t schedules = scaled(500);
  SplitMix64 random(66);
  for (std::int64_t schedule = 0; schedule < schedules; ++schedule) {
    CAPTURE(schedule);
    VirtualNetwork network;
    LinkConditions conditions;
    conditions.damage = random.uniform(0.05, 0.9);
    conditions.jitter_ns = 5 * kTestMillisecond_ns;
    VirtualClient& mine = network.add_client(conditions, random.next());
    for (std::uint32_t i = 0; i < 100; ++i) {
      network.server->broadcast(tone_item(i));
      mine.core->request(numbered_request(i));
      network.run_for(kTestMillisecond_ns);
    }
    mine.to_server.set_conditions({});
    mine.to_client.set_conditions({});
    // What came through wrong may have ended the session; it is over in time.
    network.run_for(13 * kTestSecond_ns);
    bool answered = false;
    mine.core->request(numbered_request(7), [&](const v1::Result* r) {
      answered = r != nullptr && r->code() == v1::RESULT_CODE_OK;
    });
    CHECK(network.run_until(15 * kTestSecond_ns, [&] {
      if (!answered && mine.core->heard() && random.chance(0.01)) {
        mine.core->request(numbered_request(7), [&](const v1::Result* r) {
          answered = r != nullptr && r->code() == v1::RESULT_CODE_OK;
        });
      }
      return answered;
    }));
    CHECK(network.server->session_count() <= 32);
  }
}

}  // namespace
}  // namespace hapticd::test
